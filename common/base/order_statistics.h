// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <ranges>
#include <vector>

namespace sheen {

/// The value in the middle, of an even number the upper one of two. Puts what is smaller before it, what is greater
/// behind it. There must be a value.
template <std::ranges::random_access_range Values>
std::ranges::range_value_t<Values> median(Values&& values) {
  const auto middle = std::ranges::begin(values) + std::ranges::distance(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// The same, but of an even number the mean of the two in the middle: for what is shown, and for few values.
template <typename Result, std::ranges::random_access_range Values>
Result median_of_both_middles(Values&& values) {
  const auto upper = static_cast<Result>(median(values));
  const auto count = std::ranges::distance(values);
  if (count % 2 == 1) return upper;
  const auto begin = std::ranges::begin(values);
  return (upper + static_cast<Result>(*std::max_element(begin, begin + count / 2))) / 2;
}

/// The value that a fraction q of the others, in [0, 1], lie below; of two that q is between the lower one. There must
/// be a value.
template <typename Value>
Value quantile(std::vector<Value> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace sheen
