// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kernel.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace sheen {
namespace {

/// At angles from 0 to pi from the first axis, dense near 0.
Eigen::Matrix3Xf fan(int n) {
  Eigen::Matrix3Xf directions(3, n);
  for (int i = 0; i < n; ++i) {
    const double angle = M_PI * std::pow(n > 1 ? i / (n - 1.0) : 0.0, 3), azimuth = 2.4 * i;
    directions.col(i) =
        Eigen::Vector3d(std::cos(angle), std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth))
            .cast<float>();
  }
  return directions;
}

double exact_angle(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3d x = a.cast<double>().normalized(), y = b.cast<double>().normalized();
  return std::atan2(x.cross(y).norm(), x.dot(y));
}

TEST(ViewKernel, KernelsHaveTheirClosedForms) {
  const ViewKernel matern{0.5f, 0}, exponential{0.5f, 0, KernelShape::kExponential};
  for (const float angle : {0.0f, 0.1f, 0.5f, 2.0f}) {
    const double t = angle / 0.5;
    EXPECT_NEAR(evaluate(matern, angle), (1 + std::sqrt(3.0) * t) * std::exp(-std::sqrt(3.0) * t), 1e-6);
    EXPECT_NEAR(evaluate(exponential, angle), std::exp(-t), 1e-6);
  }
}

TEST(ViewKernel, AnglesOfManyAreThoseOfTwo) {
  for (const int n : {1, 2, 15, 16, 17, 60}) {
    const Eigen::Matrix3Xf directions = fan(n);
    const Eigen::MatrixXf angles = angles_between(directions);
    ASSERT_EQ(angles.rows(), n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double exact = exact_angle(directions.col(i), directions.col(j));
        // A unit vector of floats is off by some 1e-7; next to the opposite that is the square root of it.
        const double tolerance = exact < 3 ? 3e-7 + 2e-6 * exact : 2e-3;
        EXPECT_NEAR(angles(i, j), exact, tolerance) << i << ' ' << j;
        EXPECT_NEAR(angle_between(directions.col(i), directions.col(j)), exact, tolerance) << i << ' ' << j;
        EXPECT_EQ(angles(i, j), angles(j, i));
      }
    EXPECT_TRUE(angles.diagonal().isZero(0));
  }
}

TEST(ViewKernel, CovariancesOfManyAreThoseOfTwo) {
  const Eigen::Vector3f eye = Eigen::Vector3f(1, 0.3f, -0.2f).normalized();
  for (const int n : {0, 1, 16, 33})
    for (const ViewKernel& kernel : kViewKernels) {
      const Eigen::Matrix3Xf directions = fan(n);
      const Eigen::VectorXf k = covariances(kernel, directions, eye);
      ASSERT_EQ(k.size(), n);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(k[i], evaluate(kernel, static_cast<float>(exact_angle(directions.col(i), eye))), 2e-6);
      const Eigen::MatrixXf angles = angles_between(directions), all = covariances(kernel, angles);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) EXPECT_NEAR(all(i, j), evaluate(kernel, angles(i, j)), 1e-6);
    }
}

}  // namespace
}  // namespace sheen
