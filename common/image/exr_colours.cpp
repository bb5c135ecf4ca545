// SPDX-License-Identifier: Apache-2.0
#include "common/image/exr_colours.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "common/base/errors.h"

namespace sheen {
namespace {

/// x and y (CIE 1931) of red, green, blue and white.
using Chromaticities = std::array<double, 8>;

constexpr Chromaticities kSrgb = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
constexpr double kSame = 2e-3;  // programs round them

Eigen::Vector3d xyz_of(double x, double y) {
  return {x, y, 1 - x - y};
}

Eigen::Vector3d white_of(const Chromaticities& c) {
  return xyz_of(c[6], c[7]) / c[7];
}

Eigen::Matrix3d xyz_from_rgb(const Chromaticities& c) {
  Eigen::Matrix3d primaries;
  primaries << xyz_of(c[0], c[1]), xyz_of(c[2], c[3]), xyz_of(c[4], c[5]);
  return primaries * Eigen::Vector3d(primaries.inverse() * white_of(c)).asDiagonal();
}

/// What an eye that is used to one white sees as that which it sees in the other.
Eigen::Matrix3d adaptation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  Eigen::Matrix3d cones;
  cones << 0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296;
  const Eigen::Vector3d gain = (cones * to).cwiseQuotient(cones * from);
  return cones.inverse() * gain.asDiagonal() * cones;
}

Chromaticities parse(const std::string& text) {
  Chromaticities c{};
  std::istringstream in(text);
  for (double& value : c) in >> value;
  const double area = (c[2] - c[0]) * (c[5] - c[1]) - (c[3] - c[1]) * (c[4] - c[0]);
  if (!in || !(c[7] > 0) || !(std::abs(area) > 1e-4))
    throw Error("its attribute chromaticities are no primaries: " + text);
  return c;
}

}  // namespace

void to_srgb_primaries(const ExrAttributes& attributes, ImageF& image) {
  const auto named = attributes.find("chromaticities");
  if (named == attributes.end() || image.channels() < 3) return;
  const Chromaticities c = parse(named->second);
  const auto near = [](double a, double b) { return std::abs(a - b) < kSame; };
  if (std::equal(c.begin(), c.end(), kSrgb.begin(), near)) return;
  const Eigen::Matrix3f to_srgb =
      (xyz_from_rgb(kSrgb).inverse() * adaptation(white_of(c), white_of(kSrgb)) * xyz_from_rgb(c)).cast<float>();
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      Eigen::Map<Eigen::Vector3f> rgb(image.pixel(x, y));
      rgb = (to_srgb * rgb).cwiseMax(0).eval();
    }
}

}  // namespace sheen
