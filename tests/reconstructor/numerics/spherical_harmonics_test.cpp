// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/spherical_harmonics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

TEST(SphericalHarmonics, TheFirstDegreesAreTheirClosedForms) {
  for (const Eigen::Vector3f& raw : {Eigen::Vector3f(1, 2, 3), {-1, 0.2f, -0.5f}, {0, 0, 1}, {0, 0, -1}, {0, -1, 0}}) {
    const Eigen::Vector3f d = raw.normalized();
    const Harmonics h = spherical_harmonics(d);
    EXPECT_NEAR(h[0], std::sqrt(1 / (4 * M_PI)), 1e-6);
    EXPECT_NEAR(h[1], std::sqrt(3 / (4 * M_PI)) * d.y(), 1e-6);
    EXPECT_NEAR(h[2], std::sqrt(3 / (4 * M_PI)) * d.z(), 1e-6);
    EXPECT_NEAR(h[3], std::sqrt(3 / (4 * M_PI)) * d.x(), 1e-6);
    EXPECT_NEAR(h[4], std::sqrt(15 / (4 * M_PI)) * d.x() * d.y(), 1e-6);
    EXPECT_NEAR(h[6], std::sqrt(5 / (16 * M_PI)) * (3 * d.z() * d.z() - 1), 1e-6);
    EXPECT_NEAR(h[8], std::sqrt(15 / (16 * M_PI)) * (d.x() * d.x() - d.y() * d.y()), 1e-6);
  }
}

TEST(SphericalHarmonics, TheyAreOrthonormalOverTheSphere) {
  // Midpoints in z and azimuth: exact in azimuth, accurate to about 1e-4 in z.
  constexpr int kHeights = 400, kAzimuths = 32;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(kHarmonics, kHarmonics);
  for (int i = 0; i < kHeights; ++i)
    for (int j = 0; j < kAzimuths; ++j) {
      const double z = -1 + 2 * (i + 0.5) / kHeights, a = 2 * M_PI * j / kAzimuths, r = std::sqrt(1 - z * z);
      const Eigen::VectorXd h =
          spherical_harmonics(Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z).cast<float>()).cast<double>();
      gram += h * h.transpose() * (2.0 / kHeights) * (2 * M_PI / kAzimuths);
    }
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(kHarmonics, kHarmonics)).cwiseAbs().maxCoeff(), 2e-3);
}

}  // namespace
}  // namespace sheen
