// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/exposure_gain.h"

#include <algorithm>
#include <cmath>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr double kPriorSigma = 0.3;      // of the log gain: exposures of one set differ by up to about 30 %
constexpr double kSurfacesPerFact = 20;  // neighbouring samples err together
constexpr std::size_t kFewest = 20;

}  // namespace

float robust_gain(std::span<float> log_ratios) {
  const auto end = std::remove_if(log_ratios.begin(), log_ratios.end(), [](float r) { return !std::isfinite(r); });
  const std::span<float> ratios(log_ratios.begin(), end);
  if (ratios.size() < kFewest) return 1;
  const float centre = median(ratios);
  for (float& r : ratios) r = std::abs(r - centre);
  const double sigma = 1.4826 * median(ratios);
  const double variance = sigma * sigma * kSurfacesPerFact / static_cast<double>(ratios.size());
  return static_cast<float>(std::exp(centre * kPriorSigma * kPriorSigma / (kPriorSigma * kPriorSigma + variance)));
}

}  // namespace sheen
