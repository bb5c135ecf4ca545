// SPDX-License-Identifier: Apache-2.0
// Orders and shapes that an update in sequence fears: sorted columns, sudden drift, close singular values, more terms
// than rows.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <numeric>
#include <random>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;

/// Displayed error over that of the batch.
double over_batch(const MatrixXf& data, const OnlineSvdOptions& options) {
  const OnlineSvd factor = settled_factor(data, options);
  EXPECT_EQ(broken_invariants(factor), "");
  return displayed_model_error(factor, data) / batch_pca(data, options.max_rank).relative_error;
}

TEST(Order, SortedTestPatchesAreWithinTheGoal) {
  for (const auto& [patch, goal] : {std::pair(TestPatch::kTypical, 1.001), std::pair(TestPatch::kHard, 1.01)}) {
    const MatrixXf data = test_patch_columns(patch);
    for (const std::vector<int>& order : column_orders(data, 1))
      EXPECT_LT(over_batch(data(Eigen::all, order), {.max_rank = 12, .tolerance = 0}), goal);
  }
}

TEST(Order, SuddenDriftToAnotherSpan) {
  // The lamp is moved half way: what was the whole span becomes the smaller half of it, or the larger.
  const MatrixXf first = patch_like_matrix(240, 80, 10, 0.01f, 1), second = patch_like_matrix(240, 80, 10, 0.01f, 50);
  for (const float louder : {0.3f, 1.0f, 3.0f}) {
    MatrixXf data(240, 160);
    data << first, louder * second;
    EXPECT_LT(over_batch(data, {.max_rank = 12, .tolerance = 0}), 1.02) << louder;
  }
}

TEST(Order, ASpanThatComesBackAfterALongAbsence) {
  const MatrixXf a = patch_like_matrix(200, 40, 8, 0.01f, 2), b = patch_like_matrix(200, 120, 8, 0.01f, 60);
  MatrixXf data(200, 200);
  data << a, b, a;
  EXPECT_LT(over_batch(data, {.max_rank = 12, .tolerance = 0}), 1.02);
}

TEST(Order, TheWorstThatARandomSearchFindsIsNotFarFromTheOthers) {
  // Hill climbing over permutations: swaps are kept that make the displayed error larger.
  const MatrixXf data = patch_like_matrix(96, 90, 16, 0.01f, 3);
  const OnlineSvdOptions options{.max_rank = 6, .block = 6, .tolerance = 0};
  const double best = batch_pca(data, options.max_rank).relative_error;
  std::vector<int> worst(90);
  std::iota(worst.begin(), worst.end(), 0);
  const auto error = [&](const std::vector<int>& order) {
    const MatrixXf stream = data(Eigen::all, order);
    return displayed_model_error(settled_factor(stream, options), stream) / best;
  };
  std::mt19937 engine(4);
  double most = error(worst);
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<int> order = worst;
    if (trial < 40) std::shuffle(order.begin(), order.end(), engine);
    const int swaps = 1 + static_cast<int>(engine() % 12);
    for (int i = 0; i < swaps; ++i) std::swap(order[engine() % order.size()], order[engine() % order.size()]);
    if (const double now = error(order); now > most) {
      most = now;
      worst = order;
    }
  }
  EXPECT_LT(most, 1.05);
  EXPECT_EQ(broken_invariants(settled_factor(data(Eigen::all, worst), options)), "");
}

TEST(Order, EqualSingularValuesAreNoTrouble) {
  // Twenty orthogonal directions of one size: any twelve of them are a best approximation.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(gaussian_matrix(150, 20, 5).cast<double>());
  const MatrixXf directions = (qr.householderQ() * Eigen::MatrixXd::Identity(150, 20)).cast<float>();
  MatrixXf data(150, 100);
  for (int j = 0; j < 100; ++j) data.col(j) = directions.col(j % 20);
  EXPECT_LT(over_batch(data, {.max_rank = 12, .tolerance = 0}), 1.02);
  const OnlineSvd all = settled_factor(data, {.max_rank = 20, .tolerance = 0});
  EXPECT_EQ(all.rank(), 20);
  EXPECT_LT(model_error(all, data), 1e-5);
  EXPECT_LT((all.spectrum().array() - 5).abs().maxCoeff(), 1e-5);
}

TEST(Order, DisplayedCoefficientsNeitherFlipNorSwapWhereSingularValuesCross) {
  // Two terms that take turns in being the larger one.
  const MatrixXf spans = gaussian_matrix(200, 3, 6);
  OnlineSvd factor(200, {.max_rank = 4, .tolerance = 1e-3});
  std::mt19937 engine(7);
  std::normal_distribution<float> normal;
  MatrixXf before;
  double worst = 0;
  for (int j = 0; j < 400; ++j) {
    const float first = (j / 50) % 2 ? 0.3f : 0.8f;
    factor.add(spans.col(0) + first * normal(engine) * spans.col(1) + (1.1f - first) * normal(engine) * spans.col(2));
    const MatrixXf now = factor.settled().displayed_coefficients();
    if (j > 50) {
      ASSERT_EQ(now.rows(), 3);
      worst = std::max(worst, double((now.leftCols(before.cols()) - before).norm() / before.norm()));
    }
    before = now;
  }
  EXPECT_LT(worst, 0.02) << "a sign flip would be a change of the order of 1";
}

TEST(Shape, MoreTermsThanRows) {
  for (const int rows : {1, 2, 3, 5}) {
    const MatrixXf data = gaussian_matrix(rows, 60, 8 + rows);
    const OnlineSvd factor = settled_factor(data, {.max_rank = 24, .tolerance = 0});
    EXPECT_EQ(broken_invariants(factor), "") << rows;
    EXPECT_EQ(factor.rank(), rows);
    EXPECT_LT(model_error(factor, data), 1e-5) << rows;
  }
}

TEST(Shape, FewerColumnsThanTerms) {
  for (const int columns : {1, 2, 7}) {
    const MatrixXf data = gaussian_matrix(100, columns, 20 + columns);
    const OnlineSvd factor = settled_factor(data, {.max_rank = 24, .tolerance = 0});
    EXPECT_EQ(broken_invariants(factor), "") << columns;
    EXPECT_EQ(factor.rank(), columns);
    EXPECT_LT(model_error(factor, data), 1e-5) << columns;
  }
}

TEST(Shape, AFactorWithoutColumns) {
  const OnlineSvd factor(30, {.max_rank = 4});
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_EQ(broken_invariants(factor.settled()), "");
  EXPECT_EQ(factor.settled().views(), 0);
  EXPECT_EQ(factor.displayed_error(), 0);
  EXPECT_EQ(factor.estimate(Eigen::VectorXf::Ones(30), std::vector<std::uint8_t>(30, 1), 1e-4).size(), 0);
}

TEST(Shape, EveryBlockSizeAndPhaseIsNearlyTheBatch) {
  const MatrixXf data = patch_like_matrix(120, 90, 14, 0.01f, 9);
  const double best = batch_pca(data, 8).relative_error;
  for (const int block : {1, 2, 7, 12, 32})
    for (const unsigned phase : {0U, 5U, 1000003U}) {
      OnlineSvd factor(120, {.max_rank = 8, .block = block, .tolerance = 0}, phase);
      for (int j = 0; j < 90; ++j) factor.add(data.col(j));
      factor.fold();
      EXPECT_EQ(broken_invariants(factor), "") << block << " " << phase;
      EXPECT_LT(displayed_model_error(factor, data), 1.03 * best) << block << " " << phase;
    }
}

}  // namespace
}  // namespace sheen
