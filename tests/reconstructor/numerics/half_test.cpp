// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/half.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "reconstructor/numerics/ring_factor.h"
#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;

/// What the standard says a bit pattern means, which is not infinite and not NaN.
double meaning(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
  return bits >> 15 ? -size : size;
}

/// All finite numbers in half precision, in an order in which no run of eight is special.
std::vector<std::uint16_t> finite_patterns() {
  std::vector<std::uint16_t> all;
  for (std::uint32_t i = 0; i < 65536; ++i)
    if (const auto bits = static_cast<std::uint16_t>(i * 40503u); (bits >> 10 & 31) != 31) all.push_back(bits);
  return all;
}

template <typename Scalar>
void expect_meanings() {
  const std::vector<std::uint16_t> patterns = finite_patterns();
  std::vector<Half> halves;
  for (const std::uint16_t bits : patterns) halves.push_back(std::bit_cast<Half>(bits));
  std::vector<Scalar> values(patterns.size());
  from_half(halves.data(), static_cast<Eigen::Index>(halves.size()), values.data());
  for (std::size_t i = 0; i < patterns.size(); ++i) ASSERT_EQ(values[i], meaning(patterns[i])) << patterns[i];
  std::vector<Half> again(patterns.size());
  to_half(values.data(), static_cast<Eigen::Index>(values.size()), again.data());
  for (std::size_t i = 0; i < patterns.size(); ++i) ASSERT_EQ(std::bit_cast<std::uint16_t>(again[i]), patterns[i]);
}

TEST(Half, EveryNumberMeansWhatTheStandardSaysAndComesBack) {
  expect_meanings<float>();
  expect_meanings<double>();
}

TEST(Half, RoundsToTheNearestAndHalvesToTheEvenOne) {
  // 1 + n / 1024 are numbers; so many at once that some are rounded eight at a time and some alone.
  const std::vector<float> values{1 + 0.49f / 1024,
                                  1 + 0.51f / 1024,
                                  1 + 0.5f / 1024,
                                  1 + 1.5f / 1024,
                                  -1 - 2.5f / 1024,
                                  0,
                                  65504,
                                  65519,
                                  65520,
                                  1e30f,
                                  std::ldexp(1.0f, -24),
                                  std::ldexp(0.49f, -24)};
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<float> expected{1,     1 + 1.0f / 1024, 1,        1 + 2.0f / 1024, -1 - 2.0f / 1024,      0,
                                    65504, 65504,           infinity, infinity,        std::ldexp(1.0f, -24), 0};
  std::vector<Half> halves(values.size());
  to_half(values.data(), static_cast<Eigen::Index>(values.size()), halves.data());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(static_cast<float>(halves[i]), expected[i]) << values[i];
}

TEST(KeptValues, AreExactOrRoundedWhateverTheirScale) {
  for (const float scale : {1e-40f, 1e-30f, 1.0f, 3e4f, 1e30f}) {
    const VectorXf numbers = scale * gaussian_matrix(37, 1, 3);
    const std::vector<float> values(numbers.data(), numbers.data() + numbers.size());
    const KeptValues<float> exact(values, false), rounded(values, true);
    EXPECT_EQ(exact.values(), values);
    EXPECT_EQ(2 * rounded.bytes(), exact.bytes());
    const std::vector<float> again = rounded.values();
    for (std::size_t i = 0; i < values.size(); ++i)  // a denormal float has fewer bits than a half
      EXPECT_NEAR(again[i], values[i], std::abs(values[i]) / 2048 + 1e-44) << scale;
  }
  EXPECT_TRUE(KeptValues<double>({}, true).values().empty());
}

RingFactor factor_of(const MatrixXf& data, const RingFactorOptions& options) {
  RingFactor factor(static_cast<int>(data.rows()), options);
  for (Eigen::Index j = 0; j < data.cols(); ++j) factor.add(data.col(j));
  return factor.settled();
}

double error_of(const RingFactor& factor, const MatrixXf& data) {
  return (factor.displayed_basis() * factor.displayed_coefficients() - data).norm() / data.norm();
}

TEST(RingFactorInHalf, ItsBasisIsOneOfHalvesAndItsErrorThatOfABatchSvd) {
  const MatrixXf data = ring_like_matrix(240, 120, 14, 0.01f, 5);
  RingFactorOptions options{.max_rank = 12, .block = 12, .tolerance = 0};
  const std::size_t whole = factor_of(data, options).bytes();
  options.rests_in_half = true;
  const RingFactor factor = factor_of(data, options);
  const MatrixXf basis = factor.basis();
  EXPECT_EQ(basis, basis.cast<Half>().cast<float>().eval());
  const Eigen::VectorXd s = Eigen::BDCSVD<Eigen::MatrixXd>(data.cast<double>()).singularValues();
  EXPECT_LT(error_of(factor, data), 1.01 * s.tail(s.size() - 12).norm() / s.norm());
  EXPECT_LT(orthogonality_loss(basis), 24 * 2e-4 / std::sqrt(240)) << "24 terms, of 2e-4 over the root of the rows";
  EXPECT_NEAR(factor.energy(), data.cast<double>().squaredNorm(), 1e-4 * factor.energy());
  EXPECT_LT(static_cast<double>(factor.bytes()), 0.8 * static_cast<double>(whole)) << "coefficients stay as they are";
}

TEST(RingFactorInHalf, RoundingDoesNotAddUpOverManyFolds) {
  // Exact rank 5: all that is lost, in 2,400 columns, is rounding.
  const MatrixXf data = gaussian_matrix(150, 5, 3) * gaussian_matrix(5, 2400, 4);
  const RingFactor factor =
      factor_of(data, {.max_rank = 5, .internal_rank = 8, .tolerance = 1e-3, .rests_in_half = true});
  EXPECT_LT(error_of(factor, data), 4e-3) << "a unit of half precision is 1e-3";
  EXPECT_LT(orthogonality_loss(factor.basis()), 1e-4);
}

TEST(RingFactorInHalf, HiddenRowsAreFilledAsByTheOther) {
  const MatrixXf data = ring_like_matrix(150, 60, 3, 0, 14);
  RingFactorOptions options{.max_rank = 4, .tolerance = 1e-3, .sensor_variance = 1e-6};
  std::vector<RingFactor> factors;
  for (const bool in_half : {false, true}) {
    options.rests_in_half = in_half;
    RingFactor factor(150, options);
    for (Eigen::Index j = 0; j < data.cols(); ++j) {
      std::vector<std::uint8_t> known(150, 1);
      if (j >= 10 && j % 2 == 0) std::fill_n(known.begin() + j, 60, 0);
      factor.add(data.col(j), known, j % 2 == 0 && j >= 10 ? 0.36 : 1);
    }
    for (int merged = 0; merged < 6; ++merged) factor.merge_views(12, 14);
    factor.remove(3);
    factors.push_back(factor.settled());
  }
  const MatrixXf exact = factors[0].displayed_basis() * factors[0].displayed_coefficients();
  const MatrixXf in_half = factors[1].displayed_basis() * factors[1].displayed_coefficients();
  ASSERT_EQ(exact.cols(), in_half.cols());
  EXPECT_LT((in_half - exact).norm(), 1e-3 * exact.norm());
  EXPECT_LT(factors[1].bytes(), factors[0].bytes());
}

TEST(RingFactorInHalf, LookingChangesNothing) {
  const MatrixXf data = ring_like_matrix(120, 50, 6, 0.01f, 9);
  const RingFactorOptions options{.max_rank = 8, .block = 8, .tolerance = 0.001, .rests_in_half = true};
  RingFactor watched(120, options), alone(120, options);
  const std::vector<std::uint8_t> known(120, 1);
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    watched.add(data.col(j));
    alone.add(data.col(j));
    watched.settled().displayed_coefficients();
    watched.pending_coefficients();
    watched.estimate(data.col(j), known, 1e-6);
    EXPECT_TRUE(std::isfinite(watched.value(3, VectorXf::Ones(watched.rank()))));
  }
  EXPECT_EQ(watched.basis(), alone.basis());
  EXPECT_EQ(watched.coefficients(), alone.coefficients());
  const VectorXf y = VectorXf::LinSpaced(watched.rank(), -1, 1);
  EXPECT_NEAR(watched.value(7, y), watched.basis().row(7).dot(y), 1e-6);
}

TEST(SharedRowsInHalf, AreTheRoundedColumns) {
  constexpr int kRows = 150, kFirst = 90;
  const MatrixXf data = ring_like_matrix(kRows, 40, 6, 0.01f, 3);
  const MatrixXf rounded = data.cast<Half>().cast<float>();
  RingFactor whole(kRows, {.max_rank = 6}), of_runs(kRows, {.max_rank = 6});
  const auto run = [&](Eigen::Index column, int first, int rows) {
    const auto values = std::make_shared<Half[]>(static_cast<std::size_t>(rows));
    const float peak = copy_and_peak(data.col(column).data() + first, rows, values.get());
    EXPECT_EQ(peak, data.col(column).segment(first, rows).cwiseAbs().maxCoeff());
    return SharedRows<Half>{values, rows, peak};
  };
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    whole.add(rounded.col(j));
    of_runs.add(std::vector{run(j, 0, kFirst), run(j, kFirst, kRows - kFirst)}, {}, 1);
    if (of_runs.pending() > 0) EXPECT_EQ(of_runs.pending_value(of_runs.pending() - 1, 100), rounded(100, j));
  }
  EXPECT_EQ(whole.settled().basis(), of_runs.settled().basis());
  EXPECT_EQ(whole.settled().coefficients(), of_runs.settled().coefficients());
}

TEST(SharedRowsInHalf, WhatIsBeyondThemCountsAsUnknown) {
  const std::vector<float> values{1, 7e4f, 2};
  std::vector<Half> rounded(3);
  EXPECT_FALSE(std::isfinite(copy_and_peak(values.data(), 3, rounded.data())));
  const std::vector<float> none{1, std::nanf(""), 2};
  EXPECT_FALSE(std::isfinite(copy_and_peak(none.data(), 3, rounded.data())));
}

TEST(RingFactorAim, HoldsFromTheNextFoldAndCanBeRaisedAgain) {
  const MatrixXf data = gaussian_matrix(90, 60, 24);
  RingFactor factor(90, {.max_rank = 24, .internal_rank = 30, .block = 6, .tolerance = 0});
  for (Eigen::Index j = 0; j < 30; ++j) factor.add(data.col(j));
  factor.fold();
  ASSERT_EQ(factor.rank(), 30);
  factor.aim_for(3, 5);
  EXPECT_EQ(factor.rank(), 30) << "nothing was folded yet";
  for (Eigen::Index j = 30; j < 36; ++j) factor.add(data.col(j));
  factor.fold();
  EXPECT_EQ(factor.rank(), 5);
  EXPECT_EQ(factor.displayed_rank(), 3);
  // Nearly the best of so many terms (Eckart and Young): the columns came in two folds, and each let go of terms.
  const Eigen::VectorXd s = Eigen::BDCSVD<Eigen::MatrixXd>(data.leftCols(36).cast<double>()).singularValues();
  const double best = s.tail(s.size() - 5).norm() / s.norm();
  EXPECT_GT(factor.relative_error(), (1 - 1e-5) * best);
  EXPECT_LT(factor.relative_error(), 1.005 * best);
  factor.aim_for(8, 100);
  for (Eigen::Index j = 36; j < 60; ++j) factor.add(data.col(j));
  factor.fold();
  EXPECT_EQ(factor.displayed_rank(), 8);
  EXPECT_EQ(factor.rank(), 29) << "5, and one for each column since";
  factor.limit(4, 6, 6);
  EXPECT_EQ(factor.rank(), 6) << "an aim is within the limits";
  EXPECT_THROW(factor.aim_for(0, 4), std::invalid_argument);
  EXPECT_THROW(factor.aim_for(5, 4), std::invalid_argument);
}

}  // namespace
}  // namespace sheen
