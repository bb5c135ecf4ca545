// SPDX-License-Identifier: Apache-2.0
// An online SVD whose rows are replaced by others.
#include <gtest/gtest.h>

#include <vector>

#include "reconstructor/numerics/online_svd.h"
#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

constexpr int kChannels = 3;

/// Every `step`th group of rows.
RowResampling every(int step, int rows) {
  RowResampling by;
  const int groups = (rows / kChannels + step - 1) / step;
  by.rows = kChannels * groups;
  for (int g = 0; g < groups; ++g) by.between.push_back({step * g, step * g, step * g});
  by.columns = [step, fewer = by.rows.rows()](const Eigen::MatrixXf& columns) {
    Eigen::MatrixXf out(fewer, columns.cols());
    for (int row = 0; row < fewer; row += kChannels)
      out.middleRows<kChannels>(row) = columns.middleRows<kChannels>(step * row);
    return out;
  };
  return by;
}

/// Each group, and between two the mean of both.
RowResampling twice_as_many(int rows) {
  const int groups = rows / kChannels;
  RowResampling by;
  by.rows = kChannels * (2 * groups - 1);
  for (int g = 0; g < 2 * groups - 1; ++g) by.between.push_back({g / 2, (g + 1) / 2, (g + 1) / 2});
  by.columns = [more = by.rows.rows()](const Eigen::MatrixXf& columns) {
    Eigen::MatrixXf out(more, columns.cols());
    for (int g = 0; g < more / kChannels; ++g)
      out.middleRows<kChannels>(kChannels * g) = (columns.middleRows<kChannels>(kChannels * (g / 2)) +
                                                  columns.middleRows<kChannels>(kChannels * ((g + 1) / 2))) /
                                                 2;
    return out;
  };
  return by;
}

OnlineSvd factor_of(const Eigen::MatrixXf& data, double sensor_variance = 0) {
  OnlineSvd factor(
      static_cast<int>(data.rows()),
      {.max_rank = 8, .block = 6, .tolerance = 1e-4, .channels = kChannels, .sensor_variance = sensor_variance});
  for (Eigen::Index j = 0; j < data.cols(); ++j) factor.add(data.col(j));
  factor.fold();
  return factor;
}

Eigen::MatrixXf low_rank(int rows, int columns, int rank) {
  return gaussian_matrix(rows, rank, 3) * gaussian_matrix(rank, columns, 4);
}

TEST(RowResampling, AFactorOfFewerRowsIsThatOfTheColumnsOnTheseRows) {
  const Eigen::MatrixXf data = low_rank(300, 20, 5);
  const RowResampling by = every(2, 300);
  for (const double sensor_variance : {0.0, 1e-9}) {  // in floating and in fixed point
    OnlineSvd factor = factor_of(data, sensor_variance);
    factor.resample(by);
    const Eigen::MatrixXf expected = by.columns(data);
    EXPECT_EQ(factor.rows(), by.rows.rows());
    EXPECT_EQ(factor.rank(), 5);
    EXPECT_EQ(factor.displayed_rank(), 5);
    EXPECT_LT((factor.basis() * factor.coefficients() - expected).norm(), 2e-4 * expected.norm());
    EXPECT_LT(orthogonality_loss(factor.basis()), 1e-4);
    EXPECT_NEAR(factor.energy(), expected.cast<double>().squaredNorm(), 1e-3 * factor.energy());
    EXPECT_LT((factor.spectrum() - factor_of(expected).spectrum()).norm(), 1e-3 * factor.spectrum().norm());
  }
}

TEST(RowResampling, MoreRowsAreInterpolated) {
  const Eigen::MatrixXf data = low_rank(90, 20, 4);
  const RowResampling by = twice_as_many(90);
  OnlineSvd factor = factor_of(data);
  factor.resample(by);
  const Eigen::MatrixXf expected = by.columns(data);
  EXPECT_EQ(factor.rank(), 4);
  EXPECT_LT((factor.basis() * factor.coefficients() - expected).norm(), 1e-4 * expected.norm());
  EXPECT_LT(orthogonality_loss(factor.basis()), 1e-5);
}

TEST(RowResampling, ATermThatNoRowShowsAnyLongerIsGone) {
  Eigen::MatrixXf data = low_rank(120, 15, 2);
  Eigen::VectorXf between = Eigen::VectorXf::Zero(120);
  for (int row = 0; row < 120; ++row)
    if (row / kChannels % 2 == 1) between[row] = 1;
  data += 3 * between * gaussian_matrix(1, 15, 9);
  OnlineSvd factor = factor_of(data);
  ASSERT_EQ(factor.rank(), 3);
  const RowResampling by = every(2, 120);
  factor.resample(by);
  EXPECT_EQ(factor.rank(), 2);
  EXPECT_LT((factor.basis() * factor.coefficients() - by.columns(data)).norm(), 1e-4 * by.columns(data).norm());
}

TEST(RowResampling, ItGoesOnAsOneThatNeverHadOtherRows) {
  const Eigen::MatrixXf data = low_rank(240, 40, 6);
  const RowResampling by = every(4, 240);
  const Eigen::MatrixXf expected = by.columns(data);
  OnlineSvd factor = factor_of(data.leftCols(15));
  factor.resample(by);
  for (int j = 15; j < 40; ++j) factor.add(expected.col(j));
  factor.remove(3);  // one from before, and one from after
  factor.remove(30);
  factor.fold();
  Eigen::MatrixXf left(expected.rows(), 38);
  left << expected.leftCols(3), expected.middleCols(4, 27), expected.rightCols(8);
  EXPECT_EQ(factor.rank(), 6);
  EXPECT_LT((factor.basis() * factor.coefficients() - left).norm(), 2e-4 * left.norm());
  EXPECT_NEAR(factor.energy(), left.cast<double>().squaredNorm(), 1e-3 * factor.energy());
}

TEST(RowResampling, WhatColumnsHideStaysHiddenAndRowsThatNoneShowedStayUnseen) {
  constexpr int kRows = 120, kUnseen = 30, kColumns = 16;
  const Eigen::MatrixXf data = low_rank(kRows, kColumns, 2).array() + 4;
  OnlineSvd factor(kRows, {.max_rank = 8, .block = 4, .tolerance = 1e-3, .channels = kChannels});
  for (int j = 0; j < kColumns; ++j) {
    std::vector<std::uint8_t> known(kRows, 1);
    std::fill_n(known.begin(), kUnseen, 0);
    if (j % 2 == 0) std::fill_n(known.begin() + 60, 30, 0);
    Eigen::VectorXf column = data.col(j);
    for (int row = 0; row < kRows; ++row)
      if (!known[row]) column[row] = 1e3f;  // which means nothing
    factor.add(column, known);
  }
  factor.fold();
  const RowResampling by = every(2, kRows);
  factor.resample(by);
  EXPECT_EQ(factor.basis().topRows(kUnseen / 2), Eigen::MatrixXf::Zero(kUnseen / 2, factor.rank()));
  const Eigen::MatrixXf expected = by.columns(data).bottomRows(by.rows.rows() - kUnseen / 2);
  const auto error = [&] {
    const Eigen::MatrixXf all = factor.displayed_basis() * factor.displayed_coefficients();
    return (all.leftCols(kColumns).bottomRows(expected.rows()) - expected).norm() / expected.norm();
  };
  EXPECT_LT(error(), 0.02);
  // More columns, of which the first show what none did.
  for (int j = 0; j < kColumns; ++j) factor.add(by.columns(data.col(j)));
  factor.fold();
  EXPECT_LT(error(), 0.02);
  const Eigen::MatrixXf all = factor.displayed_basis() * factor.displayed_coefficients();
  EXPECT_LT((all.rightCols(kColumns) - by.columns(data)).norm(), 0.02 * by.columns(data).norm());
}

TEST(RowResampling, OfColumnsThatWaitItIsRefused) {
  OnlineSvd factor = factor_of(low_rank(60, 12, 2));
  factor.add(low_rank(60, 1, 2));
  EXPECT_THROW(factor.resample(every(2, 60)), std::invalid_argument);
}

TEST(RowResampling, AFactorWithoutColumnsHasTheNewRows) {
  OnlineSvd factor(60, {.channels = kChannels});
  factor.resample(every(2, 60));
  EXPECT_EQ(factor.rows(), 30);
  factor.add(Eigen::VectorXf::Ones(30));
  factor.fold();
  EXPECT_EQ(factor.rank(), 1);
}

}  // namespace
}  // namespace sheen
