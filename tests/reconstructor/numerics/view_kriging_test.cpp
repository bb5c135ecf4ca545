// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/view_kriging.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

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

TEST(ViewKriging, AnExponentialKernelLooksNoFartherThanTheNextViews) {
  // Along a line it is the covariance of a Markov process: what lies behind the next views says nothing more, but for
  // the mean, which many alike views fix.
  const ViewKernel kernel{0.2f, 0, KernelShape::kExponential};
  Eigen::Matrix3Xf directions(3, 6);
  for (int j = 0; j < 6; ++j) directions.col(j) = Eigen::Vector3f(std::sin(0.2f * j), 0, std::cos(0.2f * j));
  Eigen::MatrixXf y = Eigen::MatrixXf::Zero(1, 6);
  y(0, 0) = 1;
  y(0, 5) = -1;  // the mean stays 0
  const ViewInterpolant i = krige(directions, y, Eigen::VectorXf::Ones(6), kernel);
  EXPECT_NEAR(predict(i, directions, kernel, Eigen::Vector3f(std::sin(0.5f), 0, std::cos(0.5f)))[0], 0, 1e-5);
  const float beside = predict(i, directions, kernel, Eigen::Vector3f(std::sin(0.1f), 0, std::cos(0.1f)))[0];
  EXPECT_NEAR(beside, std::sinh(0.5) / std::sinh(1.0), 1e-4);  // the bridge between 1 and 0
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
      by_hand += reliability[out] * (predict(i, d, kernel, directions.col(out)) - y.col(out)).squaredNorm();
    }
    EXPECT_NEAR(krige(directions, y, reliability, kernel).leave_one_out, by_hand, 1e-3 * by_hand);
  }
}

/// A drift that is not the same in all views.
Eigen::VectorXf some_drift(const Eigen::Matrix3Xf& directions) {
  return (2 * directions.row(0).array().square() + directions.row(1).array()).matrix().transpose();
}

TEST(ViewKriging, AMultipleOfTheDriftIsKeptEverywhere) {
  const Eigen::Matrix3Xf directions = some_directions(12, 1), elsewhere = some_directions(5, 8);
  const Eigen::VectorXf f = some_drift(directions), there = some_drift(elsewhere);
  const Eigen::Vector2f constant(3, -1), factor(0.5f, 2);
  const Eigen::MatrixXf y = constant.replicate(1, 12) + factor * f.transpose();
  for (const ViewKernel& kernel : kViewKernels) {
    const ViewInterpolant i = krige(directions, y, Eigen::VectorXf::Ones(12), kernel, f);
    ASSERT_EQ(i.drift.size(), 2);
    for (int j = 0; j < 5; ++j)
      EXPECT_LT(
          (predict(i, directions, kernel, elsewhere.col(j)) + there[j] * i.drift - constant - there[j] * factor).norm(),
          1e-3);
    EXPECT_LT(i.leave_one_out, 1e-5);
  }
}

TEST(ViewKriging, LeaveOneOutWithDriftMatchesLeavingOneOut) {
  const int n = 9;
  const Eigen::Matrix3Xf directions = some_directions(n, 4);
  const Eigen::VectorXf f = some_drift(directions);
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
      const ViewInterpolant i = krige(d, y(Eigen::all, rest), reliability(rest), kernel, f(rest));
      by_hand +=
          reliability[out] * (predict(i, d, kernel, directions.col(out)) + f[out] * i.drift - y.col(out)).squaredNorm();
    }
    EXPECT_NEAR(krige(directions, y, reliability, kernel, f).leave_one_out, by_hand, 1e-3 * by_hand);
    const LeaveOneOut both = leave_one_out(angles_between(directions), y, reliability, kernel, f);
    EXPECT_NEAR(both.with_drift, by_hand, 1e-3 * by_hand);
    EXPECT_NEAR(both.ordinary, krige(directions, y, reliability, kernel).leave_one_out, 1e-9 * by_hand);
  }
}

TEST(ViewKriging, SinglePrecisionComparesKernelsAsDoubleDoes) {
  for (const int n : {9, 40, 96}) {
    Eigen::Matrix3Xf directions = some_directions(n, 4);
    directions.col(1) = directions.col(0);  // the worst that the nugget has to hold apart
    const Eigen::MatrixXf angles = angles_between(directions), y = gaussian_matrix(6, n, 5);
    Eigen::VectorXf reliability = Eigen::VectorXf::Ones(n);
    reliability[2] = 0.01f;
    const Eigen::VectorXf varying = some_drift(directions);
    const Eigen::VectorXf hardly = (0.5f + 0.01f * varying.array()).matrix();
    for (const ViewKernel& kernel : kViewKernels)
      for (const Eigen::VectorXf& f : {varying, hardly}) {
        const LeaveOneOut exact = leave_one_out<double>(angles, y, reliability, kernel, f);
        const LeaveOneOut quick = leave_one_out<float>(angles, y, reliability, kernel, f);
        EXPECT_NEAR(quick.ordinary, exact.ordinary, 1e-5 * exact.ordinary);
        EXPECT_NEAR(quick.with_drift, exact.with_drift, 1e-3 * exact.with_drift);
      }
  }
}

TEST(ViewKriging, AViewThatAloneTellsTheDriftDoesNotOutweighAllOthersInSinglePrecision) {
  for (const int n : {6, 12, 40}) {
    const Eigen::Matrix3Xf directions = some_directions(n, 4);
    const Eigen::MatrixXf angles = angles_between(directions), y = gaussian_matrix(6, n, 5);
    const Eigen::VectorXf ones = Eigen::VectorXf::Ones(n);
    Eigen::VectorXf f = Eigen::VectorXf::Constant(n, 0.3f);
    f[3] = 0.9f;
    for (const ViewKernel& kernel : kViewKernels) {
      const LeaveOneOut quick = leave_one_out<float>(angles, y, ones, kernel, f);
      EXPECT_LT(quick.with_drift, 3 * quick.ordinary);
    }
  }
}

/// Of universal kriging, by its equations with a Lagrange multiplier (Cressie 1993, sec. 3.2).
double variance_by_hand(const Eigen::Matrix3Xf& directions, const ViewKernel& kernel, const Eigen::Vector3f& at) {
  const Eigen::Index n = directions.cols();
  Eigen::MatrixXd system = Eigen::MatrixXd::Ones(n + 1, n + 1);
  Eigen::VectorXd right = Eigen::VectorXd::Ones(n + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j)
      system(i, j) = evaluate(kernel, angle_between(directions.col(i), directions.col(j))) + (i == j) * kernel.nugget;
    right[i] = evaluate(kernel, angle_between(directions.col(i), at));
  }
  system(n, n) = 0;
  return 1 + kernel.nugget - right.dot(system.fullPivLu().solve(right));
}

TEST(PredictionVariance, IsThatOfTheKrigingEquations) {
  const Eigen::Matrix3Xf elsewhere = some_directions(8, 12);
  for (const int n : {1, 2, 6})
    for (const ViewKernel& kernel : kViewKernels) {
      const Eigen::Matrix3Xf directions = some_directions(n, 11);
      for (int i = 0; i < 8; ++i) {
        const double by_hand = variance_by_hand(directions, kernel, elsewhere.col(i));
        EXPECT_NEAR(prediction_variance(directions, kernel, elsewhere.col(i)), by_hand, 1e-4 * by_hand);
      }
    }
}

TEST(PredictionVariance, OfManyViewsTheNearestDecide) {
  const Eigen::Matrix3Xf directions = some_directions(40, 11), elsewhere = some_directions(20, 12);
  for (const ViewKernel& kernel : kViewKernels) {
    if (kernel.nugget > 0.5f) continue;  // there all views together make a mean
    for (int i = 0; i < 20; ++i) {
      const double by_hand = variance_by_hand(directions, kernel, elsewhere.col(i));
      EXPECT_NEAR(prediction_variance(directions, kernel, elsewhere.col(i)) / by_hand, 1, 0.15);
    }
  }
}

TEST(PredictionVariance, OfViewsAtOnePlaceIsFinite) {
  const Eigen::Matrix3Xf same = Eigen::Vector3f(0, 0, 1).replicate(1, 30);
  const float there = prediction_variance(same, {0.3f, 0}, {0, 0, 1}),
              far = prediction_variance(same, {0.3f, 0}, {1, 0, 0});
  EXPECT_NEAR(there, 0, 1e-3);
  EXPECT_GT(far, 1);
  EXPECT_LT(far, 3);
}

TEST(ViewKriging, TheSillOfDrawnViewsIsTheirOwn) {
  // Views drawn from the very covariance, times 0.3: the mean over many draws of what is estimated.
  constexpr int kViews = 14, kTerms = 3, kDraws = 400;
  const Eigen::Matrix3Xf directions = some_directions(kViews, 21);
  Eigen::VectorXf reliability = Eigen::VectorXf::Ones(kViews);
  reliability.head<4>().setConstant(0.3f);
  for (const ViewKernel& kernel : {kViewKernels[0], kViewKernels[2], kViewKernels[4]}) {
    Eigen::MatrixXd covariance(kViews, kViews);
    for (int i = 0; i < kViews; ++i)
      for (int j = 0; j < kViews; ++j)
        covariance(i, j) = evaluate(kernel, angle_between(directions.col(i), directions.col(j))) +
                           (i == j) * kernel.nugget / reliability[i];
    const Eigen::MatrixXf root = Eigen::MatrixXd(covariance.llt().matrixL()).cast<float>();
    double sum = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const Eigen::MatrixXf y = std::sqrt(0.3f) * gaussian_matrix(kTerms, kViews, 100 + draw) * root.transpose();
      sum += krige(directions, (y.array() + 5).matrix(), reliability, kernel).sill / kDraws;
    }
    EXPECT_NEAR(sum, kTerms * 0.3, 0.06 * kTerms * 0.3);
  }
}

TEST(ViewKriging, ADriftThatDoesNotVaryIsLeftOut) {
  const Eigen::Matrix3Xf directions = some_directions(9, 4);
  const Eigen::MatrixXf y = gaussian_matrix(2, 9, 5);
  const Eigen::VectorXf ones = Eigen::VectorXf::Ones(9), same = Eigen::VectorXf::Constant(9, 0.7f);
  const ViewInterpolant with = krige(directions, y, ones, kViewKernels[1], same);
  const ViewInterpolant without = krige(directions, y, ones, kViewKernels[1]);
  EXPECT_EQ(with.drift.size(), 0);
  EXPECT_EQ(with.weights, without.weights);
  EXPECT_FALSE(std::isfinite(leave_one_out(angles_between(directions), y, ones, kViewKernels[1], same).with_drift));
}

TEST(ViewKriging, FewViewsTryNoDrift) {
  const int n = kFewestViewsWithDrift - 1;
  const Eigen::Matrix3Xf directions = some_directions(n, 4);
  const LeaveOneOut errors = leave_one_out(angles_between(directions), gaussian_matrix(2, n, 5),
                                           Eigen::VectorXf::Ones(n), kViewKernels[1], some_drift(directions));
  EXPECT_TRUE(std::isfinite(errors.ordinary));
  EXPECT_FALSE(std::isfinite(errors.with_drift));
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

TEST(ViewKriging, AtOneDirectionItIsTheSame) {
  for (const int n : {1, 2, 3, 8, 40}) {
    const Eigen::Matrix3Xf directions = some_directions(n, 31);
    const Eigen::MatrixXf y = gaussian_matrix(3, n, 32);
    Eigen::VectorXf reliability = gaussian_matrix(n, 1, 33).cwiseAbs().array() + 0.05f;
    const Eigen::VectorXf drift = gaussian_matrix(n, 1, 34), level = Eigen::VectorXf::Constant(n, 0.5f);
    const Eigen::Vector3f at = Eigen::Vector3f(0.1f, 0.4f, 0.9f).normalized();
    for (const ViewKernel& kernel : kViewKernels)
      for (const Eigen::VectorXf& f : {Eigen::VectorXf(), level, drift}) {
        const ViewInterpolant all = krige(directions, y, reliability, kernel, f);
        Eigen::VectorXf expected = interpolate(all, directions, kernel, at);
        if (all.drift.size() > 0)
          expected += ViewKriging(directions, reliability, kernel, f)
                          .believed_drift()
                          .at(0.7f, covariances(kernel, directions, at)) *
                      all.drift;
        EXPECT_LT((krige_at(at, 0.7f, directions, y, reliability, kernel, f) - expected).norm(),
                  1e-4 * (1 + expected.norm()))
            << n << " views, drift of " << f.size();
      }
  }
  EXPECT_EQ(krige_at({0, 0, 1}, 0, Eigen::Matrix3Xf(3, 0), Eigen::MatrixXf(2, 0), Eigen::VectorXf(0), kViewKernels[0]),
            Eigen::Vector2f::Zero());
}

TEST(BelievedDrift, IsTheDriftWhereThereAreViews) {
  const Eigen::Matrix3Xf directions = some_directions(20, 4);
  const Eigen::VectorXf f = some_drift(directions);
  for (const ViewKernel& kernel : kViewKernels) {
    const BelievedDrift believed = ViewKriging(directions, Eigen::VectorXf::Ones(20), kernel, f).believed_drift();
    for (int j = 0; j < 20; ++j)
      EXPECT_NEAR(believed.at(f[j], covariances(kernel, directions, directions.col(j))), f[j],
                  (0.02 + 0.1 * kernel.nugget) * f.norm());
  }
}

TEST(BelievedDrift, OrdinaryKrigingIsLeftOfOneThatRunsAway) {
  const Eigen::Matrix3Xf directions = some_directions(20, 4);
  const Eigen::MatrixXf y = gaussian_matrix(2, 20, 5);
  const Eigen::VectorXf ones = Eigen::VectorXf::Ones(20), f = some_drift(directions);
  const Eigen::Vector3f at = Eigen::Vector3f(0.3f, 0.1f, -0.9f).normalized();
  for (const ViewKernel& kernel : kViewKernels) {
    const Eigen::VectorXf ordinary = krige_at(at, 0, directions, y, ones, kernel);
    for (const float away : {-1e6f, 1e6f})
      EXPECT_LT((krige_at(at, away, directions, y, ones, kernel, f) - ordinary).norm(), 1e-3);
  }
}

TEST(BelievedDrift, AddsLessThanAStandardDeviationOfTheViewsAndChangesWithoutAStep) {
  const int n = 12;
  const Eigen::Matrix3Xf directions = some_directions(n, 4);
  const Eigen::MatrixXf y = gaussian_matrix(1, n, 5);
  const Eigen::VectorXf ones = Eigen::VectorXf::Ones(n), f = some_drift(directions);
  const Eigen::Vector3f at = Eigen::Vector3f(0.3f, 0.1f, -0.9f).normalized();
  for (const ViewKernel& kernel : kViewKernels) {
    const float ordinary = krige_at(at, 0, directions, y, ones, kernel)[0];
    const double deviation = std::sqrt(krige(directions, y, ones, kernel).sill);
    float before = krige_at(at, -20, directions, y, ones, kernel, f)[0];
    for (float there = -20; there < 20; there += 0.01f) {
      const float now = krige_at(at, there, directions, y, ones, kernel, f)[0];
      EXPECT_LT(std::abs(now - ordinary), deviation);
      EXPECT_LT(std::abs(now - before), 0.1 * deviation);
      before = now;
    }
  }
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
