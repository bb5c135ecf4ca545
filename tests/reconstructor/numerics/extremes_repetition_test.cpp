// SPDX-License-Identifier: Apache-2.0
// Streams that say the same again and again, or nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/support/matchers.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr int kRows = 300;

/// 97 columns that differ from one by 1e-4 of its norm.
MatrixXf near_duplicates() {
  const VectorXf column = patch_like_matrix(kRows, 1, 0, 0, 1);
  return column.replicate(1, 97) + 5e-5f * gaussian_matrix(kRows, 97, 2);
}

template <typename Scalar>
BasicOnlineSvd<Scalar> fold_round_and_round(const MatrixXf& pool, int columns, const OnlineSvdOptions& options) {
  BasicOnlineSvd<Scalar> factor(static_cast<int>(pool.rows()), options);
  for (int i = 0; i < columns; ++i) {
    factor.add(pool.col(i % pool.cols()).cast<Scalar>());
    while (factor.folded_views() > 64) factor.merge_views(0, 1);
  }
  return factor.settled();
}

TEST(Repetition, TwentyThousandNearDuplicatesStayOrthonormalAndExact) {
  constexpr int kColumns = 200 * 97;
  const MatrixXf pool = near_duplicates();
  // No tolerance: every rest is appended, which is where orthogonality is lost.
  const OnlineSvd factor = fold_round_and_round<float>(pool, kColumns, {.max_rank = 12, .tolerance = 0});
  EXPECT_EQ(broken_invariants(factor), "");
  const BatchPca exact = batch_pca(pool, 12, std::vector<double>(97, 200));
  EXPECT_NEAR(std::sqrt(factor.spectrum()[0]) / exact.singular_values[0], 1, 2e-6);
  EXPECT_NEAR(factor.energy() / (200 * pool.cast<double>().squaredNorm()), 1, 4e-6);
}

TEST(Repetition, DoublePrecisionIsExactToItsOwnRounding) {
  const MatrixXf pool = near_duplicates();
  const OnlineSvdDouble factor = fold_round_and_round<double>(pool, 20 * 97, {.max_rank = 12, .tolerance = 0});
  EXPECT_EQ(broken_invariants(factor), "");
  const BatchPca exact = batch_pca(pool, 12, std::vector<double>(97, 20));
  EXPECT_NEAR(std::sqrt(factor.spectrum()[0]) / exact.singular_values[0], 1, 1e-12);
}

TEST(Repetition, NearDuplicatesWithinTheToleranceAreOneTerm) {
  const OnlineSvd factor = fold_round_and_round<float>(near_duplicates(), 2000, {.max_rank = 12, .tolerance = 1e-3});
  EXPECT_EQ(factor.rank(), 1);
  EXPECT_EQ(broken_invariants(factor), "");
}

TEST(Repetition, OneColumnRepeatedIsOneTermOfThatLength) {
  const VectorXf column = patch_like_matrix(kRows, 1, 0, 0, 3);
  for (const double tolerance : {0.0, 0.01}) {
    const OnlineSvd factor = settled_factor(column.replicate(1, 500), {.max_rank = 8, .tolerance = tolerance});
    EXPECT_EQ(factor.rank(), 1) << tolerance;
    EXPECT_NEAR(std::sqrt(factor.spectrum()[0]), std::sqrt(500.0) * column.norm(), 1e-5 * column.norm());
    EXPECT_LT(model_error(factor, column.replicate(1, 500)), 1e-6);
    EXPECT_EQ(broken_invariants(factor), "");
  }
}

TEST(Repetition, ZeroColumnsKeepTheirPlaceAmongOthers) {
  MatrixXf data = patch_like_matrix(kRows, 60, 4, 0.01f, 4);
  for (const int zero : {0, 1, 7, 30, 59}) data.col(zero).setZero();
  const OnlineSvd factor = settled_factor(data, {.max_rank = 12, .tolerance = 0});
  ASSERT_EQ(factor.views(), 60);
  for (const int zero : {0, 1, 7, 30, 59}) EXPECT_EQ(factor.coefficients().col(zero).norm(), 0) << zero;
  EXPECT_LT(displayed_model_error(factor, data), 1.01 * batch_pca(data, 12).relative_error);
  EXPECT_EQ(broken_invariants(factor), "");
}

TEST(Repetition, NothingButZerosIsRankZero) {
  OnlineSvd factor(kRows, {.max_rank = 4});
  for (int i = 0; i < 40; ++i) factor.add(VectorXf::Zero(kRows));
  factor.fold();
  EXPECT_EQ(factor.rank(), 0);
  EXPECT_EQ(factor.views(), 40);
  EXPECT_EQ(factor.relative_error(), 0);
  EXPECT_EQ(broken_invariants(factor), "");
  // And something may still come.
  factor.add(VectorXf::Ones(kRows));
  factor.fold();
  EXPECT_EQ(factor.rank(), 1);
  EXPECT_NEAR((factor.basis() * factor.coefficients().col(40) - VectorXf::Ones(kRows)).norm(), 0, 1e-5);
}

TEST(Repetition, CoefficientsOfTheFirstViewsDoNotDrift) {
  // Everything lies in a span of seven: whatever comes later, the first columns are still told exactly.
  const MatrixXf data = patch_like_matrix(kRows, 400, 6, 0, 5);
  OnlineSvd factor(kRows, {.max_rank = 12, .tolerance = 1e-6});
  for (int i = 0; i < 40; ++i) factor.add(data.col(i));
  for (int i = 0; i < 6000; ++i) {
    factor.add(data.col(40 + i % 360));
    while (factor.folded_views() > 64) factor.merge_views(50, 51);
  }
  const OnlineSvd settled = factor.settled();
  const MatrixXf first = settled.basis() * settled.coefficients().leftCols(40);
  EXPECT_LT((first - data.leftCols(40)).norm(), 1e-4 * data.leftCols(40).norm());
  EXPECT_EQ(broken_invariants(settled), "");
}

TEST(Repetition, CoefficientsStayWhileTheBasisTurnsWithEveryBlock) {
  // Noise without end turns the guard terms at each fold; rounding of a thousand rotations may not add up in Y.
  const MatrixXf span = patch_like_matrix(kRows, 50, 5, 0, 6);
  OnlineSvd factor(kRows, {.max_rank = 6, .tolerance = 0});
  for (int i = 0; i < 50; ++i) factor.add(span.col(i));
  for (int i = 0; i < 10000; ++i) {
    factor.add(span.col(i % 50) + 1e-4f * gaussian_matrix(kRows, 1, 100 + i % 500));
    while (factor.folded_views() > 64) factor.merge_views(52, 53);
  }
  const OnlineSvd settled = factor.settled();
  const MatrixXf first = settled.basis() * settled.coefficients().leftCols(50);
  EXPECT_LT((first - span).norm(), 1e-3 * span.norm());
  EXPECT_EQ(broken_invariants(settled), "");
}

}  // namespace
}  // namespace sheen
