// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <ranges>

namespace sheen {

/// The value in the middle, of an even number the upper one of two. Puts what is smaller before it, what is greater
/// behind it. There must be a value.
template <std::ranges::random_access_range Values>
std::ranges::range_value_t<Values> median(Values&& values) {
  const auto middle = std::ranges::begin(values) + std::ranges::distance(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace sheen
