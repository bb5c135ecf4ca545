// SPDX-License-Identifier: Apache-2.0
// Columns of which hardly anything is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;
using Mask = std::vector<std::uint8_t>;

constexpr OnlineSvdOptions kOptions{.max_rank = 8, .tolerance = 0};

OnlineSvd trained_on(const MatrixXf& data, const OnlineSvdOptions& options = kOptions) {
  return settled_factor(data, options);
}

TEST(Missing, OneVisibleRowIsCompletedWithinReason) {
  const MatrixXf data = patch_like_matrix(150, 61, 8, 0.01f, 1);
  OnlineSvd factor = trained_on(data.leftCols(60));
  for (const int row : {0, 77, 149}) {
    Mask known(150, 0);
    known[row] = 1;
    const VectorXf filled = factor.basis() * factor.estimate(data.col(60), known, factor.row_noise());
    EXPECT_LT((filled - data.col(60)).norm(), data.col(60).norm()) << "better than black";
    factor.add(data.col(60), known, 1.0 / 150);
  }
  const OnlineSvd settled = factor.settled();
  EXPECT_EQ(broken_invariants(settled), "");
  EXPECT_EQ(settled.views(), 63);
}

TEST(Missing, AStreamOfSingleRowsFromTheStartStaysSound) {
  const MatrixXf data = patch_like_matrix(60, 240, 3, 0.01f, 2);
  OnlineSvd factor(60, kOptions);
  for (int j = 0; j < 240; ++j) {
    Mask known(60, 0);
    known[(7 * j) % 60] = 1;
    factor.add(data.col(j), known, 1.0 / 60);
    if (j % 31 == 0) EXPECT_EQ(broken_invariants(factor), "") << j;
  }
  const OnlineSvd settled = factor.settled();
  EXPECT_EQ(broken_invariants(settled), "");
  EXPECT_LT((settled.basis() * settled.coefficients()).norm(), 4 * data.norm()) << "nothing runs away";
}

TEST(Missing, ResidualsThatLieInTheBasisButForTheirLastDigits) {
  // One direction is left, and what columns that hide rows say of it drowns in what the basis explains.
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const int rows = 4 + static_cast<int>(seed % 5);
    OnlineSvd factor(rows, {.max_rank = rows, .block = 1 + static_cast<int>(seed % 11), .tolerance = 0});
    MatrixXf data = gaussian_matrix(rows, rows - 1, seed) * gaussian_matrix(rows - 1, 40, seed + 1);
    data += 1e-5f * gaussian_matrix(rows, 40, seed + 2);
    for (int j = 0; j < 40; ++j) {
      Mask known(rows, 1);
      if (j > rows) known[random() % rows] = 0;
      factor.add((j % 3 == 0 ? 1e3f : 1.0f) * data.col(j), known);
      ASSERT_EQ(broken_invariants(factor), "") << "seed " << seed << ", column " << j;
    }
  }
}

TEST(Missing, AColumnOfWhichOnlyADimRowIsKnownIsNotBrighterThanAThousandTimesIt) {
  constexpr int kRows = 40;
  VectorXf dim = VectorXf::Ones(kRows);
  dim[7] = 6e-6f;
  for (const float scale : {1.0f, 1e30f, 1e36f}) {
    OnlineSvd factor(kRows, {.max_rank = 2, .tolerance = 0});
    for (int j = 0; j < 20; ++j) factor.add(scale * dim);
    Mask known(kRows, 0);
    known[7] = 1;
    VectorXf bright = VectorXf::Zero(kRows);
    bright[7] = scale;
    for (int j = 0; j < 20; ++j) factor.add(bright, known);
    const OnlineSvd settled = factor.settled();
    EXPECT_EQ(broken_invariants(settled), "") << scale;
    const MatrixXf filled = settled.displayed_basis() * (settled.displayed_coefficients() / scale);
    EXPECT_LT(filled.cwiseAbs().maxCoeff(), 1e3f) << scale;
    EXPECT_TRUE(filled.allFinite()) << scale;
  }
}

TEST(Missing, PartsThatNoColumnShowsTogetherAreNotDark) {
  // A diffuse patch of which some columns show the first rows, others the last, and none both.
  const MatrixXf data = patch_like_matrix(300, 24, 0, 0.01f, 2);
  for (const int block : {1, 12}) {
    OnlineSvd factor(300, {.max_rank = 6, .block = block, .tolerance = 0.05});
    for (int j = 0; j < 24; ++j) {
      Mask known(300, 0);
      std::fill(known.begin() + (j % 2 ? 180 : 0), known.begin() + (j % 2 ? 300 : 120), 1);
      factor.add(data.col(j), known);
    }
    const OnlineSvd settled = factor.settled();
    EXPECT_EQ(settled.displayed_rank(), 1);
    const MatrixXf completed = settled.displayed_basis() * settled.displayed_coefficients();
    for (const int first : {0, 180}) {  // on one scale, which nothing tells exactly, each part is right in all columns
      const MatrixXf part = completed.middleRows(first, 120), truth = data.middleRows(first, 120);
      EXPECT_LT((part - truth).norm(), 0.2 * truth.norm()) << first;
    }
  }
}

TEST(Missing, WhatIsBlackWhereItIsShownHasNothingToDisplay) {
  OnlineSvd factor(60, kOptions);
  const Mask half = [] {
    Mask known(60, 0);
    std::fill_n(known.begin(), 30, 1);
    return known;
  }();
  for (int j = 0; j < 20; ++j) factor.add(VectorXf::Zero(60), half);
  EXPECT_EQ(factor.settled().displayed_coefficients().rows(), 0);
  EXPECT_EQ(factor.settled().displayed_coefficients().cols(), 20);
}

TEST(Missing, NoVisibleRowAtAllIsAViewWithoutWeightOnTheBasis) {
  const MatrixXf data = patch_like_matrix(150, 40, 4, 0.01f, 3);
  OnlineSvd factor = trained_on(data);
  const double energy = factor.energy();
  for (int i = 0; i < 30; ++i) factor.add(data.col(i), Mask(150, 0));
  const OnlineSvd settled = factor.settled();
  EXPECT_EQ(broken_invariants(settled), "");
  EXPECT_NEAR(settled.energy(), energy, 1e-6 * energy) << "nothing was seen, so nothing was learned";
}

TEST(Missing, VisibleRowsThatDoNotSpanTheBasisLeaveTheRestToThePrior) {
  // Two halves that vary independently of each other: the first says nothing of the second.
  MatrixXf data = MatrixXf::Zero(200, 81);
  data.topRows(100) = patch_like_matrix(100, 81, 3, 0.01f, 4);
  data.bottomRows(100) = gaussian_matrix(100, 4, 5) * gaussian_matrix(4, 81, 6);
  const OnlineSvd factor = trained_on(data.leftCols(80), {.max_rank = 12, .tolerance = 0});
  Mask known(200, 0);
  std::fill_n(known.begin(), 100, 1);
  const VectorXf filled = factor.basis() * factor.estimate(data.col(80), known, factor.row_noise());
  EXPECT_LT((filled.head(100) - data.col(80).head(100)).norm(), 0.05 * data.col(80).head(100).norm());
  const float typical = data.bottomRows(100).norm() / 9;
  EXPECT_LT(filled.tail(100).norm(), 1.5f * typical) << "chance correlations are not blown up";
}

TEST(Missing, WhatStandsBehindAMaskIsNeverRead) {
  const MatrixXf data = patch_like_matrix(120, 60, 4, 0.01f, 7);
  std::mt19937 engine(8);
  OnlineSvd zeros(120, kOptions), garbage(120, kOptions);
  for (int j = 0; j < 60; ++j) {
    VectorXf a = data.col(j), b = data.col(j);
    Mask known(120);
    for (int i = 0; i < 120; ++i) {
      known[i] = engine() % 3 != 0;
      if (known[i]) continue;
      a[i] = 0;
      b[i] = i % 2 ? 1e30f : std::numeric_limits<float>::quiet_NaN();
    }
    zeros.add(a, known);
    garbage.add(b, known);
  }
  zeros.fold();
  garbage.fold();
  EXPECT_EQ(MatrixXf(zeros.basis()), MatrixXf(garbage.basis()));
  EXPECT_EQ(zeros.coefficients(), garbage.coefficients());
}

TEST(Missing, RowsThatNoColumnShowsStayZero) {
  const MatrixXf data = patch_like_matrix(90, 50, 4, 0.01f, 9);
  OnlineSvd factor(90, kOptions);
  Mask known(90, 1);
  std::fill_n(known.begin() + 30, 12, 0);
  for (int j = 0; j < 50; ++j) factor.add(data.col(j), known);
  factor.fold();
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_EQ(factor.basis().middleRows(30, 12).norm(), 0);
}

TEST(Missing, TwoPercentOfTheRowsCompleteAColumnBetterThanLeastSquares) {
  const MatrixXf data = test_patch_columns(TestPatch::kHard);
  const std::vector<int> order = column_orders(data, 1)[3];
  OnlineSvd factor(static_cast<int>(data.rows()), {.max_rank = 12, .tolerance = 0, .channels = 3});
  for (int i = 0; i < 200; ++i) factor.add(data.col(order[i]));
  factor.fold();
  std::mt19937 engine(11);
  std::vector<double> errors, least_squares;
  for (int i = 200; i < 240; ++i) {
    const VectorXf column = data.col(order[i]);
    Mask known(static_cast<std::size_t>(column.size()), 0);
    for (int s = 0; s < 16; ++s) std::fill_n(known.begin() + 3 * static_cast<long>(engine() % kTestPatchSamples), 3, 1);
    const auto error = [&](double noise) {
      const VectorXf filled = factor.basis() * factor.estimate(column, known, noise);
      return double((filled - column).norm() / column.norm());
    };
    errors.push_back(error(factor.row_noise()));
    least_squares.push_back(error(1e-9 * factor.row_noise()));  // the prior counts for nothing
  }
  std::sort(errors.begin(), errors.end());
  std::sort(least_squares.begin(), least_squares.end());
  EXPECT_LT(errors[20], 0.45);
  EXPECT_LT(errors[39], 0.8) << "the worst one, too";
  EXPECT_GT(least_squares[20], 1.5 * errors[20]) << "what it is compared with";
}

/// Columns of three terms; the third is a fiftieth of the first two in the early columns, which hide half of the rows,
/// and as strong as they are later.
struct LateTerm {
  static constexpr int kRows = 180, kEarly = 12, kLater = 48;
  MatrixXf columns{kRows, kEarly + kLater};
  Mask known = Mask(kRows, 1);  ///< rows that the early columns show

  LateTerm() {
    std::mt19937 engine(5);
    std::normal_distribution<float> normal;
    const auto random = [&](auto) { return normal(engine); };
    const MatrixXf terms = MatrixXf::NullaryExpr(kRows, 3, [&](auto, auto) { return normal(engine); });
    for (int j = 0; j < columns.cols(); ++j) {
      Eigen::Vector3f y = Eigen::Vector3f::NullaryExpr(random);
      if (j < kEarly) y[2] = j % 2 == 0 ? 0.02f : -0.02f;
      columns.col(j) = terms * y;
    }
    for (int row = 0; row < kRows; ++row) known[row] = row % 20 < 10;
  }
  /// Of the known rows: what the displayed view leaves of a column, relative to what there was of the third term.
  double left_of(const OnlineSvd& factor, int view, const VectorXf& column) const {
    VectorXf left = column - factor.displayed_basis() * factor.displayed_coefficients().col(view);
    for (int row = 0; row < kRows; ++row)
      if (!known[row]) left[row] = 0;
    return left.norm() / (0.02 * std::sqrt(kRows / 2.0));
  }
};

TEST(Missing, WhatWasDroppedOfAPartlyHiddenViewIsFoundAgainWhenTheBasisHasLearntIt) {
  const LateTerm scene;
  OnlineSvd factor(LateTerm::kRows, {.max_rank = 8, .tolerance = 0.06});
  for (int j = 0; j < LateTerm::kEarly; ++j) factor.add(scene.columns.col(j), scene.known);
  factor.fold();
  ASSERT_EQ(factor.rank(), 2) << "the third term was not worth keeping";
  EXPECT_GT(scene.left_of(factor, 3, scene.columns.col(3)), 0.8);
  for (int j = LateTerm::kEarly; j < scene.columns.cols(); ++j) factor.add(scene.columns.col(j));
  factor.fold();
  ASSERT_EQ(factor.rank(), 3);
  for (int j = 0; j < LateTerm::kEarly; ++j) EXPECT_LT(scene.left_of(factor, j, scene.columns.col(j)), 0.1) << j;
  EXPECT_EQ(broken_invariants(factor), "");
}

TEST(Missing, WhatMergedViewsShowedIsTheirMeanAndOneCanBeTakenOut) {
  const LateTerm scene;
  OnlineSvd factor(LateTerm::kRows, {.max_rank = 8, .tolerance = 0.06});
  for (int j = 0; j < LateTerm::kEarly; ++j) factor.add(scene.columns.col(j), scene.known, j == 2 ? 3 : 1);
  factor.fold();
  factor.merge_views(0, 2);  // both have +0.02 of the third term
  for (int j = LateTerm::kEarly; j < scene.columns.cols(); ++j) factor.add(scene.columns.col(j));
  factor.fold();
  EXPECT_LT(scene.left_of(factor, 0, 0.25f * scene.columns.col(0) + 0.75f * scene.columns.col(2)), 0.1);
  factor.take_from(0, scene.columns.col(2), scene.known, 3);
  EXPECT_LT(scene.left_of(factor, 0, scene.columns.col(0)), 0.1);
  EXPECT_EQ(broken_invariants(factor), "");
}

TEST(Missing, AnOccludedStreamIsNearlyAsGoodAsAFullOne) {
  const MatrixXf data = test_patch_columns(TestPatch::kHard);
  const auto visible = occluding_edges(kTestPatchViews, 0.8, 1);
  const std::vector<int> order = column_orders(data, 1)[3];
  OnlineSvd factor(static_cast<int>(data.rows()), {.max_rank = 12, .tolerance = 0, .channels = 3});
  for (const int j : order) {
    const Mask known(visible.col(j).begin(), visible.col(j).end());
    const double fraction = visible.col(j).cast<double>().mean();
    factor.add(data.col(j), known, fraction * fraction);
  }
  factor.fold();
  EXPECT_EQ(broken_invariants(factor), "");
  const Eigen::MatrixXd basis = factor.displayed_basis().cast<double>(), columns = data.cast<double>();
  const double error = (columns - basis * (basis.transpose() * columns)).norm() / columns.norm();
  EXPECT_LT(error, 1.09 * batch_pca(data, 12).relative_error);
}

}  // namespace
}  // namespace sheen
