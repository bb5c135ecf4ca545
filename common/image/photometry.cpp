// SPDX-License-Identifier: Apache-2.0
#include "common/image/photometry.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr double kLeastVignette = 0.02, kGreatestVignette = 50;
constexpr double kLargestCoefficient = 1e3, kLargestBalance = 1e4;
constexpr int kVignetteChecks = 64;  ///< places along each side of the image

}  // namespace

double Vignette::at(double x, double y, ImageSize size) const {
  const double half_square = 0.25 * (double(size.width) * size.width + double(size.height) * size.height);
  const double r2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / half_square;
  return 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
}

std::string validation_error(const Photometry& p, ImageSize size) {
  const auto within = [](double value, double low, double high) { return value >= low && value <= high; };  // not NaN
  for (const float value : p.response)
    if (!within(value, 0, 1)) return "photometry.response must lie between 0 and 1";
  if (!std::is_sorted(p.response.begin(), p.response.end())) return "photometry.response must never fall";
  if (p.response.back() != 1) return "photometry.response must end at 1";
  for (const float gain : p.white_balance)
    if (!within(gain, 1 / kLargestBalance, kLargestBalance)) return "photometry.white_balance must be 1e-4..1e4";
  if (!within(p.saturation, 1e-3, 1)) return "photometry.saturation must be 0.001..1";
  const Vignette& v = p.vignette;
  if (!within(v.cx, -size.width, 2 * size.width) || !within(v.cy, -size.height, 2 * size.height))
    return "photometry.vignette_centre lies too far outside the image";
  for (const double k : v.k)
    if (!within(k, -kLargestCoefficient, kLargestCoefficient)) return "photometry.vignette must be -1000..1000";
  for (int j = 0; j <= kVignetteChecks; ++j)
    for (int i = 0; i <= kVignetteChecks; ++i) {
      const double x = double(size.width - 1) * i / kVignetteChecks, y = double(size.height - 1) * j / kVignetteChecks;
      if (!within(v.at(x, y, size), kLeastVignette, kGreatestVignette))
        return "photometry.vignette must lie between 0.02 and 50 all over the image";
    }
  return {};
}

}  // namespace sheen
