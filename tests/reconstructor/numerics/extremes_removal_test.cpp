// SPDX-License-Identifier: Apache-2.0
// Images that are taken back, long after or all of them.
#include <gtest/gtest.h>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;

MatrixXf without(const MatrixXf& columns, Eigen::Index removed) {
  MatrixXf rest(columns.rows(), columns.cols() - 1);
  rest << columns.leftCols(removed), columns.rightCols(columns.cols() - removed - 1);
  return rest;
}

TEST(Removal, OfAStrangerLongAfterLeavesNoTrace) {
  for (const TestPatch patch : {TestPatch::kTypical, TestPatch::kHard}) {
    MatrixXf data = test_patch_columns(patch);
    data.col(17) = 3 * data.col(17).cwiseAbs().maxCoeff() * gaussian_matrix(2448, 1, 1);
    const OnlineSvdOptions options{.max_rank = 12, .tolerance = 0};
    OnlineSvd factor = settled_factor(data, options);
    factor.remove(17);
    const MatrixXf rest = without(data, 17);
    EXPECT_EQ(broken_invariants(factor), "");
    EXPECT_LT(displayed_model_error(factor, rest), 1.005 * displayed_model_error(settled_factor(rest, options), rest));
  }
}

TEST(Removal, OfAStrangerIsForgottenByTheNoiseThatImputationTrusts) {
  for (const int stranger : {30, 58}) {
    MatrixXf data = patch_like_matrix(120, 60, 3, 0.01f, 12);
    data.col(stranger) = gaussian_matrix(120, 1, 13);
    const OnlineSvdOptions options{.max_rank = 6, .tolerance = 0.005};
    const double never = settled_factor(without(data, stranger), options).row_noise();
    OnlineSvd factor = settled_factor(data, options);
    factor.remove(stranger);
    EXPECT_GT(factor.row_noise(), 0.5 * never) << stranger;
    EXPECT_LT(factor.row_noise(), 2 * never) << stranger;
  }
}

TEST(Removal, OfEverythingLeavesAnEmptyFactorThatWorks) {
  for (const float scale : {1e-25f, 1.0f, 1e25f}) {
    const MatrixXf data = scale * patch_like_matrix(90, 40, 5, 0.01f, 2);
    OnlineSvd factor = settled_factor(data, {.max_rank = 6, .tolerance = 0});
    for (int left = 40; left > 0; --left) {
      factor.remove((left * 7) % left);
      ASSERT_EQ(broken_invariants(factor), "") << left;
    }
    EXPECT_EQ(factor.views(), 0);
    EXPECT_LT(factor.energy(), 1e-6 * data.cast<double>().squaredNorm()) << scale;
    for (int j = 0; j < 40; ++j) factor.add(data.col(j));
    factor.fold();
    EXPECT_EQ(broken_invariants(factor), "");
    EXPECT_LT(displayed_model_error(factor, data), 1.02 * batch_pca(data, 6).relative_error) << scale;
  }
}

TEST(Removal, OfTheOnlyColumnInItsDirectionGivesTheRankBack) {
  MatrixXf data = patch_like_matrix(120, 50, 2, 0, 3);
  data.col(25) = gaussian_matrix(120, 1, 4);
  OnlineSvd factor = settled_factor(data, {.max_rank = 8, .tolerance = 1e-4});
  ASSERT_EQ(factor.rank(), 4);
  factor.remove(25);
  EXPECT_EQ(factor.rank(), 3);
  EXPECT_LT(model_error(factor, without(data, 25)), 1e-3);
}

TEST(Removal, OfAHighlightTenThousandTimesTheRestKeepsTheRest) {
  MatrixXf data = patch_like_matrix(120, 50, 3, 0.005f, 5);
  const MatrixXf rest = without(data, 20);
  data.col(20).segment(30, 6).setConstant(1e4f);
  OnlineSvd factor = settled_factor(data, {.max_rank = 8, .tolerance = 0});
  factor.remove(20);
  EXPECT_EQ(broken_invariants(factor), "");
  // Rounding of 1e4 in single precision is 1e-3 of the rest's values.
  EXPECT_LT(displayed_model_error(factor, rest), 1.2 * batch_pca(rest, 8).relative_error);
}

TEST(Removal, OfWhatIsStillPendingIsAsIfItHadNeverCome) {
  const MatrixXf data = patch_like_matrix(90, 120, 5, 0.01f, 6);
  OnlineSvd stream(90, {.max_rank = 6, .tolerance = 0});
  int added = 0;
  while (added < 60 || stream.pending() < 5) stream.add(data.col(added++));
  for (int removed = stream.folded_views(); removed < added; ++removed) {
    OnlineSvd factor = stream, never(90, {.max_rank = 6, .tolerance = 0});
    for (int j = 0; j < added; ++j)
      if (j != removed) never.add(data.col(j));
    factor.remove(removed);
    const OnlineSvd a = factor.settled(), b = never.settled();
    EXPECT_EQ(MatrixXf(a.basis()), MatrixXf(b.basis())) << removed;
    EXPECT_EQ(a.coefficients(), b.coefficients()) << removed;
  }
}

TEST(Removal, OfAnOccludedColumn) {
  const MatrixXf data = patch_like_matrix(120, 60, 4, 0.01f, 7);
  OnlineSvd factor(120, {.max_rank = 8, .tolerance = 0}), never(120, {.max_rank = 8, .tolerance = 0});
  std::vector<std::uint8_t> known(120, 1);
  std::fill_n(known.begin() + 50, 60, 0);
  for (int j = 0; j < 60; ++j) {
    const bool occluded = j == 31;
    factor.add(data.col(j), occluded ? known : std::vector<std::uint8_t>{});
    if (!occluded) never.add(data.col(j));
  }
  factor.fold();
  never.fold();
  factor.remove(31);
  const MatrixXf rest = without(data, 31);
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_LT(displayed_model_error(factor, rest), 1.005 * displayed_model_error(never, rest));
}

TEST(Removal, AThousandTimesInAndOutWearsNothingOut) {
  const MatrixXf data = patch_like_matrix(90, 40, 5, 0.01f, 8), visitors = patch_like_matrix(90, 37, 9, 0.05f, 30);
  OnlineSvd factor = settled_factor(data, {.max_rank = 6, .tolerance = 0});
  for (int i = 0; i < 1000; ++i) {
    factor.add(visitors.col(i % 37));
    factor.fold();
    factor.remove(40);
  }
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_EQ(factor.views(), 40);
  EXPECT_LT(displayed_model_error(factor, data), 1.02 * batch_pca(data, 6).relative_error);
  EXPECT_NEAR(factor.energy(), data.cast<double>().squaredNorm(), 1e-3 * factor.energy());
}

}  // namespace
}  // namespace sheen
