// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/point_kriging.h"

#include <gtest/gtest.h>

#include <random>

namespace sheen {
namespace {

Eigen::Matrix3Xd dome(int count) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Eigen::Matrix3Xd points(3, count);
  for (int i = 0; i < count; ++i) {
    points.col(i) = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    points(2, i) = std::abs(points(2, i));
  }
  return points;
}

template <typename Function>
Eigen::VectorXf values(const Eigen::Matrix3Xd& points, const Function& f) {
  Eigen::VectorXf v(points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) v[i] = static_cast<float>(f(points.col(i)));
  return v;
}

const PointKernel kKernels[] = {{PointKernelShape::kLinear, 1, 1}, {PointKernelShape::kThinPlate, 1, 1},
                                {PointKernelShape::kCubic, 1, 1},  {PointKernelShape::kCubic, 1, 0},
                                {PointKernelShape::kCubic, 2, 1},  {PointKernelShape::kThinPlate, 3, 1}};

TEST(PointKrigingTest, ReproducesWhatWasMeasured) {
  const Eigen::Matrix3Xd points = dome(40);
  for (const PointKernel& kernel : kKernels) {
    const PointKriging kriging(points, kernel);
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      Eigen::VectorXf expected = Eigen::VectorXf::Zero(points.cols());
      expected[i] = 1;
      EXPECT_LT((kriging.weights(points.col(i)) - expected).cwiseAbs().maxCoeff(), 1e-5f);
    }
  }
}

/// Harmonic polynomials up to the degree of the drift, anywhere in space.
TEST(PointKrigingTest, ReproducesItsDriftExactly) {
  const Eigen::Matrix3Xd points = dome(40);
  const Eigen::Vector3d place(0.3, -0.5, 0.6);
  const auto first = [](const Eigen::Vector3d& p) { return 3 - 2 * p.x() + p.y() + 5 * p.z(); };
  const auto second = [](const Eigen::Vector3d& p) {
    return p.x() * p.y() - 2 * p.y() * p.z() + p.x() * p.x() - p.z() * p.z();
  };
  const auto third = [](const Eigen::Vector3d& p) {
    return p.x() * p.y() * p.z() + p.x() * (p.x() * p.x() - 3 * p.y() * p.y());
  };
  for (const PointKernel& kernel : kKernels) {
    const Eigen::VectorXf weights = PointKriging(points, kernel).weights(place);
    EXPECT_NEAR(weights.sum(), 1, 1e-5);
    EXPECT_NEAR(weights.dot(values(points, first)), first(place), 2e-5);
    if (kernel.drift_degree >= 2) EXPECT_NEAR(weights.dot(values(points, second)), second(place), 2e-5);
    if (kernel.drift_degree >= 3) EXPECT_NEAR(weights.dot(values(points, third)), third(place), 2e-5);
  }
}

TEST(PointKrigingTest, LeavingOneOutIsKrigingWithoutIt) {
  const Eigen::Matrix3Xd points = dome(30);
  const Eigen::VectorXf measured = values(points, [](const auto& p) { return std::exp(2 * p.x()) + std::abs(p.y()); });
  for (const PointKernel& kernel : kKernels) {
    const Eigen::VectorXf errors = PointKriging(points, kernel).leave_one_out() * measured;
    for (Eigen::Index i = 0; i < points.cols(); i += 7) {
      Eigen::Matrix3Xd others(3, points.cols() - 1);
      others << points.leftCols(i), points.rightCols(points.cols() - 1 - i);
      Eigen::VectorXf of_others(points.cols() - 1);
      of_others << measured.head(i), measured.tail(points.cols() - 1 - i);
      const double predicted = PointKriging(others, kernel).weights(points.col(i)).dot(of_others);
      EXPECT_NEAR(errors[i], measured[i] - predicted, 2e-3 * (1 + std::abs(predicted)));
    }
  }
}

/// Lights of a gantry stand in a plane: one coordinate says nothing.
TEST(PointKrigingTest, PointsMayLieInAPlaneOrBeFew) {
  Eigen::Matrix3Xd plane(3, 16);
  for (int i = 0; i < 16; ++i) plane.col(i) = Eigen::Vector3d(i % 4, i / 4, 2);
  const auto f = [](const Eigen::Vector3d& p) { return 1 + p.x() - 3 * p.y(); };
  const Eigen::VectorXf weights = PointKriging(plane, {PointKernelShape::kCubic, 1, 1}).weights({1.4, 2.3, 2});
  EXPECT_NEAR(weights.dot(values(plane, f)), f({1.4, 2.3, 2}), 1e-4);

  for (int count = 1; count <= 5; ++count) {
    const Eigen::VectorXf few = PointKriging(dome(5).leftCols(count), {}).weights({0, 0, 1});
    EXPECT_TRUE(few.allFinite());
    EXPECT_NEAR(few.sum(), 1, 1e-4) << count;
  }
}

TEST(PointKrigingTest, ChoosesTheKernelThatPredicts) {
  const Eigen::Matrix3Xd points = dome(60);
  const PointKernel smooth{PointKernelShape::kCubic, 3, 1}, rough{PointKernelShape::kLinear, 1, 1};
  const PointKernel kernels[] = {smooth, rough};
  const auto chosen = [&](const auto& f) {
    const Eigen::VectorXd v = values(points, f).template cast<double>();
    return choose_kernel(points, v * v.transpose(), kernels);
  };
  EXPECT_EQ(chosen([](const auto& p) { return std::sin(2 * p.x() + p.y()); }), smooth);
  EXPECT_EQ(chosen([](const auto& p) { return p.x() > 0.1 ? 1.0 : 0.0; }), rough);
}

}  // namespace
}  // namespace sheen
