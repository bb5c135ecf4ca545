// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/band_rounding.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/light_field_file/patch_spectrum.h"

namespace sheen {
namespace {

constexpr float kLargest = 1 << 22;
constexpr float kLeastExpected = 0.03f;

float square(float x) {
  return x * x;
}

/// Of a size whose like are as large as expected (geometric distribution), with a sign.
float bits_of(std::int32_t size, float expected) {
  const float zero = std::log2(1 + expected);
  return size == 0 ? zero : zero + 1 + static_cast<float>(size) * (zero - std::log2(expected));
}

struct Choice {
  std::int32_t size = 0;
  float error = 0, bits = 0;
};

/// Of a size in steps: next below, next above or zero.
Choice choose(float exact, float expected, float bit_price) {
  const auto below = static_cast<std::int32_t>(std::min(exact, kLargest));
  Choice best;
  float least = INFINITY;
  for (const std::int32_t size : {below + 1, below, 0}) {
    const Choice choice{size, square(exact - rounded_value(size)), bits_of(size, expected)};
    const float cost = choice.error + bit_price * choice.bits;
    if (cost >= least) continue;
    least = cost;
    best = choice;
  }
  return best;
}

}  // namespace

/// By the frequencies before, the same frequency in the tiles before, and, not yet rounded, the next ones.
float BandRounding::expected(const Eigen::Ref<const Eigen::VectorXf>& frequencies,
                             const std::vector<std::int32_t>& before, const std::vector<float>& past) const {
  constexpr float kBefore[] = {6, 4, 3, 2}, kPast = 8, kNext = 3;
  const std::size_t f = before.size();
  float sum = 0, weights = 0;
  const auto add = [&](float weight, float size) {
    sum += weight * size;
    weights += weight;
  };
  if (!past.empty()) add(kPast, f < past.size() ? past[f] : 0);
  for (std::size_t d = 1; d <= 4 && d <= f; ++d) add(kBefore[d - 1], static_cast<float>(std::abs(before[f - d])));
  for (auto next = static_cast<Eigen::Index>(f) + 1; next <= static_cast<Eigen::Index>(f) + 2; ++next)
    if (next < frequencies.size()) add(kNext, std::max(0.0f, std::abs(frequencies[next]) - 0.2f));
  return std::max(weights > 0 ? sum / weights : std::abs(frequencies[static_cast<Eigen::Index>(f)]), kLeastExpected);
}

std::vector<std::int32_t> BandRounding::rounded(const Eigen::Ref<const Eigen::VectorXf>& frequencies, int colour) {
  std::vector<float>& past = past_[static_cast<std::size_t>(colour)];
  std::vector<std::int32_t> values;
  values.reserve(static_cast<std::size_t>(frequencies.size()));
  float gain = 0, most = 0;  // of what is kept so far, over nothing
  std::size_t end = 0;
  for (const float exact : frequencies) {
    const Choice choice = choose(std::abs(exact), expected(frequencies, values, past), bit_price_);
    values.push_back(exact < 0 ? -choice.size : choice.size);
    gain += square(exact) - choice.error - bit_price_ * choice.bits;
    if (gain <= most) continue;
    most = gain;
    end = values.size();
  }
  values.resize(end);
  while (!values.empty() && values.back() == 0) values.pop_back();

  const bool first = past.empty();
  past.resize(std::max(past.size(), static_cast<std::size_t>(frequencies.size())), 0.0f);
  for (std::size_t f = 0; f < static_cast<std::size_t>(frequencies.size()); ++f) {
    const float size = f < values.size() ? static_cast<float>(std::abs(values[f])) : 0.0f;
    past[f] += (size - past[f]) * (first ? 1.0f : 0.25f);
  }
  return values;
}

}  // namespace sheen
