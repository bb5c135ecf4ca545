// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kriging.h"

#include <gtest/gtest.h>

#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

Eigen::Matrix3Xf some_directions(int n, std::uint32_t seed) {
  Eigen::Matrix3Xf d = gaussian_matrix(3, n, seed);
  d.row(2) = d.row(2).cwiseAbs();
  return d.colwise().normalized();
}

Eigen::VectorXf predict(const ViewInterpolant& interpolant, const Eigen::Matrix3Xf& directions,
                        const ViewKernel& kernel, const Eigen::Vector3f& at) {
  Eigen::VectorXf k(directions.cols());
  for (Eigen::Index j = 0; j < k.size(); ++j) k[j] = evaluate(kernel, angle_between(directions.col(j), at));
  return interpolant.mean + interpolant.weights * k;
}

TEST(ViewKriging, AConstantIsKeptEverywhere) {
  const Eigen::Matrix3Xf directions = some_directions(12, 1);
  const Eigen::MatrixXf constant = Eigen::Vector2f(3, -1).replicate(1, 12);
  for (const ViewKernel& kernel : kViewKernels) {
    const ViewInterpolant i = krige(directions, constant, Eigen::VectorXf::Ones(12), kernel);
    EXPECT_LT((predict(i, directions, kernel, Eigen::Vector3f(0.1f, 0.9f, 0.3f).normalized()) - Eigen::Vector2f(3, -1))
                  .norm(),
              1e-4);
    EXPECT_LT(i.leave_one_out, 1e-6);
  }
}

TEST(ViewKriging, WithoutANuggetItPassesThroughTheViews) {
  const Eigen::Matrix3Xf directions = some_directions(10, 2);
  const Eigen::MatrixXf y = gaussian_matrix(3, 10, 3);
  const ViewKernel kernel{0.3f, 1e-6f};
  const ViewInterpolant i = krige(directions, y, Eigen::VectorXf::Ones(10), kernel);
  for (int j = 0; j < 10; ++j) EXPECT_LT((predict(i, directions, kernel, directions.col(j)) - y.col(j)).norm(), 1e-3);
}

TEST(ViewKriging, LeaveOneOutMatchesLeavingOneOut) {
  const int n = 9;
  const Eigen::Matrix3Xf directions = some_directions(n, 4);
  const Eigen::MatrixXf y = gaussian_matrix(2, n, 5);
  Eigen::VectorXf reliability = Eigen::VectorXf::Ones(n);
  reliability[2] = 0.5f;
  for (const ViewKernel& kernel : kViewKernels) {
    double by_hand = 0;
    for (int out = 0; out < n; ++out) {
      std::vector<int> rest;
      for (int j = 0; j < n; ++j)
        if (j != out) rest.push_back(j);
      const Eigen::Matrix3Xf d = directions(Eigen::all, rest);
      const ViewInterpolant i = krige(d, y(Eigen::all, rest), reliability(rest), kernel);
      by_hand += (predict(i, d, kernel, directions.col(out)) - y.col(out)).squaredNorm();
    }
    EXPECT_NEAR(krige(directions, y, reliability, kernel).leave_one_out, by_hand, 1e-3 * by_hand);
  }
}

TEST(ViewKriging, FarFromEveryViewTheMeanIsReturned) {
  Eigen::Matrix3Xf directions(3, 3);
  directions << 1, 0.99f, 0.98f, 0, 0.05f, -0.1f, 0, 0.1f, 0.1f;
  directions.colwise().normalize();
  const Eigen::MatrixXf y = gaussian_matrix(2, 3, 6);
  const ViewKernel kernel{0.15f, 0.02f};
  const ViewInterpolant i = krige(directions, y, Eigen::VectorXf::Ones(3), kernel);
  EXPECT_LT((predict(i, directions, kernel, {-1, 0, 0}) - i.mean).norm(), 1e-4);
}

TEST(ViewKriging, NoViewAndOneViewAreFine) {
  const ViewKernel kernel;
  EXPECT_EQ(krige(Eigen::Matrix3Xf(3, 0), Eigen::MatrixXf(2, 0), Eigen::VectorXf(), kernel).weights.cols(), 0);
  const Eigen::Matrix3Xf one = Eigen::Vector3f(0, 0, 1);
  const ViewInterpolant i = krige(one, Eigen::Vector2f(5, 7), Eigen::VectorXf::Ones(1), kernel);
  EXPECT_LT((predict(i, one, kernel, {1, 0, 0}) - Eigen::Vector2f(5, 7)).norm(), 1e-5);
}

TEST(ViewKriging, RepeatedDirectionsDoNotBreakIt) {
  const Eigen::Matrix3Xf same = Eigen::Vector3f(0, 0, 1).replicate(1, 30);
  const Eigen::MatrixXf y = gaussian_matrix(2, 30, 7);
  const ViewInterpolant i = krige(same, y, Eigen::VectorXf::Ones(30), kViewKernels[0]);
  EXPECT_TRUE(i.weights.allFinite());
  EXPECT_LT((predict(i, same, kViewKernels[0], {0, 0, 1}) - y.rowwise().mean()).norm(), 0.1);
}

}  // namespace
}  // namespace sheen
