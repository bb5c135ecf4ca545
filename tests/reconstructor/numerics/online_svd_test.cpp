// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/online_svd.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <numeric>
#include <random>

#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

OnlineSvd factor_of(const Eigen::MatrixXf& data, const OnlineSvdOptions& options) {
  OnlineSvd factor(static_cast<int>(data.rows()), options);
  for (Eigen::Index j = 0; j < data.cols(); ++j) factor.add(data.col(j));
  factor.fold();
  return factor;
}

double relative_error(const OnlineSvd& factor, const Eigen::MatrixXf& data) {
  return (factor.basis() * factor.coefficients() - data).norm() / data.norm();
}

/// Relative error of the best approximation of this rank (Eckart and Young).
double best_relative_error(const Eigen::MatrixXf& data, int rank) {
  const Eigen::VectorXd s = Eigen::BDCSVD<Eigen::MatrixXd>(data.cast<double>()).singularValues();
  return s.tail(s.size() - std::min<Eigen::Index>(rank, s.size())).norm() / s.norm();
}

TEST(OnlineSvd, HoldsEverythingWhenItMay) {
  const Eigen::MatrixXf data = gaussian_matrix(90, 20, 1);
  const OnlineSvd factor = factor_of(data, {.max_rank = 32, .block = 8, .tolerance = 0});
  EXPECT_EQ(factor.rank(), 20);
  EXPECT_LT(relative_error(factor, data), 1e-5);
  EXPECT_LT(orthogonality_loss(factor.basis()), 1e-6);
  EXPECT_NEAR(factor.energy(), data.cast<double>().squaredNorm(), 1e-4 * factor.energy());
}

TEST(OnlineSvd, ADiffusePatchCostsOneTerm) {
  const Eigen::MatrixXf data = patch_like_matrix(300, 60, 0, 0.01f, 2);
  const OnlineSvd factor = factor_of(data, {.max_rank = 24, .block = 12, .tolerance = 0.02});
  EXPECT_EQ(factor.rank(), 1);
  EXPECT_LT(relative_error(factor, data), 0.02);
}

TEST(OnlineSvd, RankGrowsOnlyWhereTheDataAskForIt) {
  const Eigen::MatrixXf data = gaussian_matrix(200, 5, 3) * gaussian_matrix(5, 80, 4);
  OnlineSvd factor = factor_of(data, {.max_rank = 24, .block = 12, .tolerance = 1e-3});
  EXPECT_EQ(factor.rank(), 5);
  EXPECT_LT(relative_error(factor, data), 2e-3);
}

TEST(OnlineSvd, NearlyAsGoodAsBatchInAnyOrder) {
  // The truncation must not depend on luck: sorted orders are the worst for a plain Brand update.
  const Eigen::MatrixXf data = patch_like_matrix(240, 120, 14, 0.01f, 5);
  const int rank = 12;
  const double best = best_relative_error(data, rank);
  std::vector<Eigen::Index> order(data.cols());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 engine(6);
  const Eigen::VectorXf norms = data.colwise().norm();
  for (int trial = 0; trial < 6; ++trial) {
    if (trial == 1) std::sort(order.begin(), order.end(), [&](auto a, auto b) { return norms[a] < norms[b]; });
    if (trial == 2) std::reverse(order.begin(), order.end());
    if (trial > 2) std::shuffle(order.begin(), order.end(), engine);
    const Eigen::MatrixXf permuted = data(Eigen::all, order);
    const OnlineSvd factor = factor_of(permuted, {.max_rank = rank, .block = 12, .tolerance = 0});
    const Eigen::MatrixXf top = factor.displayed_basis() * factor.displayed_coefficients();
    EXPECT_LT((top - permuted).norm() / permuted.norm(), 1.01 * best) << "order " << trial;
    EXPECT_LT(orthogonality_loss(factor.basis()), 1e-6);
  }
}

TEST(OnlineSvd, KnowsItsOwnError) {
  const Eigen::MatrixXf data = patch_like_matrix(200, 100, 20, 0.02f, 7);
  const OnlineSvd factor = factor_of(data, {.max_rank = 8, .block = 8, .tolerance = 0.01});
  const double actual = relative_error(factor, data);
  EXPECT_GT(factor.relative_error(), 0.95 * actual);
  EXPECT_LT(factor.relative_error(), 1.10 * actual);
}

TEST(OnlineSvd, SingularValuesAreSortedAndMatchBatch) {
  const Eigen::MatrixXf data = patch_like_matrix(150, 40, 6, 0, 8);
  const OnlineSvd factor = factor_of(data, {.max_rank = 24, .block = 12, .tolerance = 0});
  const Eigen::VectorXd exact = Eigen::BDCSVD<Eigen::MatrixXd>(data.cast<double>()).singularValues();
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(std::sqrt(factor.spectrum()[i]), exact[i], 1e-6 * exact[0]) << i;
  for (int i = 1; i < factor.rank(); ++i) EXPECT_LE(factor.spectrum()[i], factor.spectrum()[i - 1]);
}

TEST(OnlineSvdEstimate, IsTheProjectionWhenEverythingIsKnown) {
  const Eigen::MatrixXf data = patch_like_matrix(120, 30, 6, 0.01f, 13);
  const OnlineSvd factor = factor_of(data, {.max_rank = 8, .block = 8, .tolerance = 0});
  const std::vector<std::uint8_t> all(120, 1);
  const Eigen::VectorXf y = factor.estimate(data.col(3), all, 0);
  const Eigen::VectorXf projected = factor.basis().transpose() * data.col(3);
  EXPECT_LT((y - projected).norm(), 1e-3 * projected.norm());
}

TEST(OnlineSvdEstimate, FillsHiddenRowsFromTheOthers) {
  const Eigen::MatrixXf data = patch_like_matrix(150, 41, 3, 0, 14);
  const OnlineSvd factor = factor_of(data.leftCols(40), {.max_rank = 8, .block = 8, .tolerance = 0});
  std::vector<std::uint8_t> known(150, 0);
  std::fill_n(known.begin(), 50, 1);
  const Eigen::VectorXf filled = factor.basis() * factor.estimate(data.col(40), known, 1e-9);
  EXPECT_LT((filled - data.col(40)).norm(), 0.01 * data.col(40).norm()) << "the new column lies in the span";
}

TEST(OnlineSvdReveal, RowsSeenLateAreTakenToHaveVariedLikeTheRest) {
  // Patch of one level a view; its last thirty rows, seen by the last column only, are half as bright as the mean.
  const Eigen::VectorXf colours = (0.5f + 0.1f * gaussian_matrix(120, 1, 16).array()).matrix();
  const Eigen::RowVectorXf level = (1.0f + 0.2f * gaussian_matrix(1, 8, 17).array()).matrix();
  Eigen::MatrixXf data = colours * level;
  data.bottomRows(30) = Eigen::VectorXf::Constant(30, 0.5f * colours.head(90).mean()) * level;
  std::vector<std::uint8_t> early(120, 1);
  std::fill_n(early.begin() + 90, 30, 0);
  OnlineSvd factor(120, {.max_rank = 8, .block = 8, .tolerance = 0});
  for (int j = 0; j < 7; ++j) factor.add(data.col(j), early);
  factor.add(data.col(7));
  factor.fold();
  EXPECT_EQ(factor.rank(), 1);
  EXPECT_LT((factor.basis() * factor.coefficients() - data).norm(), 1e-4 * data.norm());
  EXPECT_LT(orthogonality_loss(factor.basis()), 1e-6);
  EXPECT_NEAR(factor.energy(), data.cast<double>().squaredNorm(), 1e-3 * factor.energy());
}

TEST(OnlineSvdMerge, TheBasisStaysAndLaterViewsMoveUp) {
  const Eigen::MatrixXf data = patch_like_matrix(60, 6, 3, 0, 17);
  OnlineSvd factor(60, {.max_rank = 8, .block = 8, .tolerance = 0});
  for (int j = 0; j < 6; ++j) factor.add(data.col(j), j == 1 ? 3 : 1);
  factor.fold();
  const Eigen::MatrixXf before = factor.basis() * factor.coefficients();
  const double energy = factor.energy();
  factor.merge_views(1, 3);
  ASSERT_EQ(factor.views(), 5);
  const Eigen::MatrixXf after = factor.basis() * factor.coefficients();
  EXPECT_LT((after.col(1) - (0.75f * before.col(1) + 0.25f * before.col(3))).norm(), 1e-5);
  EXPECT_LT((after.col(3) - before.col(4)).norm(), 1e-5);
  EXPECT_LT((after.col(4) - before.col(5)).norm(), 1e-5);
  EXPECT_EQ(factor.energy(), energy);
  EXPECT_EQ(factor.weight_of(1), 4);
}

TEST(OnlineSvdPending, LookingChangesNothing) {
  const Eigen::MatrixXf data = patch_like_matrix(90, 45, 8, 0.01f, 18);
  const OnlineSvdOptions options{.max_rank = 6, .block = 8, .tolerance = 0.01};
  OnlineSvd watched(90, options), alone(90, options);
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    watched.add(data.col(j));
    alone.add(data.col(j));
    const OnlineSvd now = watched.settled();
    EXPECT_EQ(now.pending(), 0);
    EXPECT_EQ(now.views(), j + 1);
    EXPECT_EQ(watched.pending_coefficients().cols(), watched.pending());
  }
  EXPECT_EQ(watched.basis(), alone.basis());
  EXPECT_EQ(watched.coefficients(), alone.coefficients());
}

TEST(OnlineSvdPending, PendingCoefficientsAreTheProjection) {
  const Eigen::MatrixXf data = patch_like_matrix(90, 21, 4, 0.01f, 19);
  OnlineSvd factor(90, {.max_rank = 8, .block = 8, .tolerance = 0});
  for (Eigen::Index j = 0; j < data.cols(); ++j) factor.add(data.col(j));
  ASSERT_GT(factor.pending(), 0);
  const Eigen::MatrixXf expected = factor.basis().transpose() * data.rightCols(factor.pending());
  EXPECT_LT((factor.pending_coefficients() - expected).norm(), 1e-5 * expected.norm());
}

TEST(OnlineSvdPending, PhasesSpreadTheFolds) {
  const Eigen::VectorXf c = patch_like_matrix(12, 1, 0, 0, 20);
  constexpr int kPhases = 240, kColumns = 120, kBlock = 12;
  std::vector<int> folds(kColumns, 0);
  for (unsigned phase = 0; phase < kPhases; ++phase) {
    OnlineSvd factor(12, {.max_rank = 2, .block = kBlock}, phase);
    for (int i = 0; i < kColumns; ++i) folds[i] += factor.add(c).empty() ? 0 : 1;
  }
  for (int i = 0; i < 8; ++i) EXPECT_EQ(folds[i], kPhases) << "column " << i << ": folded at once";
  for (int i = 60; i < kColumns; ++i) EXPECT_LE(folds[i], 1.5 * kPhases / kBlock) << "column " << i;
}

TEST(OnlineSvdRemove, EqualsNeverInserted) {
  const Eigen::MatrixXf data = patch_like_matrix(200, 60, 10, 0.01f, 21);
  OnlineSvd factor(200, {.max_rank = 8, .block = 8, .tolerance = 0});
  for (Eigen::Index j = 0; j < data.cols(); ++j) factor.add(data.col(j));
  Eigen::MatrixXf rest(200, 0);
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    if (j % 6 == 1) continue;
    rest.conservativeResize(Eigen::NoChange, rest.cols() + 1);
    rest.rightCols(1) = data.col(j);
  }
  for (int j = 59; j >= 0; --j)
    if (j % 6 == 1) factor.remove(j);
  factor.fold();
  ASSERT_EQ(factor.views(), rest.cols());
  const double error = (factor.displayed_basis() * factor.displayed_coefficients() - rest).norm() / rest.norm();
  EXPECT_LT(error, 1.005 * best_relative_error(rest, 8));
  EXPECT_NEAR(factor.energy(), rest.cast<double>().squaredNorm(), 1e-5 * factor.energy());
  EXPECT_LT(orthogonality_loss(factor.basis()), 1e-6);
}

TEST(OnlineSvdLimit, LeavesTheBestOfSoManyTerms) {
  const Eigen::MatrixXf data = gaussian_matrix(90, 30, 24);
  OnlineSvd factor(90, {.max_rank = 30, .block = 12, .tolerance = 0});
  for (Eigen::Index j = 0; j < 30; ++j) factor.add(data.col(j));  // some still wait to be folded
  const std::size_t before = factor.bytes();
  factor.limit(5, 9, 4);
  EXPECT_EQ(factor.rank(), 9);
  EXPECT_EQ(factor.displayed_rank(), 5);
  EXPECT_EQ(factor.folded_views(), 30);
  EXPECT_LT(factor.bytes(), before / 2);
  EXPECT_LT(orthogonality_loss(factor.basis()), 1e-6);
  EXPECT_NEAR(relative_error(factor, data), best_relative_error(data, 9), 1e-4);
  EXPECT_NEAR(factor.relative_error(), best_relative_error(data, 9), 1e-4) << "and the factor knows";
  for (int j = 0; j < 30; ++j) factor.add(data.col(j));
  EXPECT_EQ(factor.rank(), 9) << "the limits last";
  EXPECT_LT(factor.pending(), 4);
}

TEST(OnlineSvdRemove, AMergedViewGivesOneOfItsColumnsBack) {
  const Eigen::MatrixXf data = patch_like_matrix(80, 20, 4, 0, 23);
  OnlineSvd factor = factor_of(data, {.max_rank = 12, .block = 8, .tolerance = 0});
  const double energy = factor.energy();
  const Eigen::VectorXf before = factor.basis() * factor.coefficients().col(3);
  factor.merge_views(3, 7);
  factor.take_from(3, data.col(7), {}, 1);
  ASSERT_EQ(factor.views(), 19);
  const Eigen::VectorXf after = factor.basis() * factor.coefficients().col(3);
  EXPECT_LT((after - before).norm(), 1e-4 * before.norm());
  EXPECT_EQ(factor.weight_of(3), 1);
  EXPECT_NEAR(factor.energy(), energy - data.col(7).squaredNorm(), 1e-4 * energy);
  factor.take_from(3, data.col(3), {}, 1);
  EXPECT_EQ(factor.views(), 18);
}

}  // namespace
}  // namespace sheen
