// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_columns.h"

#include <gtest/gtest.h>

#include "reconstructor/numerics/online_svd.h"
#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

TEST(PackedColumns, FixedPointIsWrongByHalfAStepAtMost) {
  for (const int rows : {1, 7, 64, 101, 300}) {
    const Eigen::MatrixXf columns = gaussian_matrix(rows, 3, 1) * Eigen::Vector3f(1, 1e-30f, 1e30f).asDiagonal();
    const auto packed = PackedColumns<float>::fixed_point(columns);
    const Eigen::MatrixXf out = packed.unpacked();
    for (int k = 0; k < 3; ++k) {
      const double half_step = 0.501 * columns.col(k).cast<double>().cwiseAbs().maxCoeff() / 32767;
      EXPECT_LE((out - columns).col(k).cast<double>().cwiseAbs().maxCoeff(), half_step) << rows << " " << k;
      EXPECT_EQ(packed.column(k), out.col(k));
      for (int row = 0; row < rows; ++row) EXPECT_EQ(packed.at(row, k), out(row, k));
    }
    const Eigen::VectorXf y = gaussian_matrix(rows, 1, 2).col(0);
    Eigen::VectorXf products(3);
    packed.inner_products(y, products);
    const Eigen::VectorXd expected = out.cast<double>().transpose() * y.cast<double>();
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(products[k], expected[k], 1e-6 * out.col(k).cast<double>().norm() * y.norm()) << rows << " " << k;
    EXPECT_EQ(packed.leading((rows + 1) / 2, 2).unpacked(), out.topLeftCorner((rows + 1) / 2, 2));
    EXPECT_EQ(packed.alike(out).unpacked(), out) << "packing what was unpacked changes nothing";
  }
}

TEST(PackedColumns, ThoseBehindTheFineOnesTakeAByteAValue) {
  for (const int fine : {0, 2, 5}) {
    const Eigen::MatrixXf columns = gaussian_matrix(60, 5, 3);
    const auto packed = PackedColumns<float>::fixed_point(columns, fine);
    const Eigen::MatrixXf out = packed.unpacked();
    for (int k = 0; k < 5; ++k) {
      const float most = columns.col(k).cwiseAbs().maxCoeff() / (k < fine ? 32767 : 127);
      EXPECT_LE((out - columns).col(k).cwiseAbs().maxCoeff(), 0.501f * most) << fine << " " << k;
      EXPECT_EQ(packed.column(k), out.col(k));
      EXPECT_EQ(packed.at(17, k), out(17, k));
    }
    Eigen::VectorXf products(5);
    packed.inner_products(columns.col(0), products);
    EXPECT_LT((products - out.transpose() * columns.col(0)).norm(), 1e-4f);
    int visited = 0;
    packed.visit(4, [&](Eigen::Index k, const auto& value) {
      EXPECT_EQ(k, visited++);
      for (int row = 0; row < 60; ++row) EXPECT_EQ(value(row), out(row, k));
    });
    EXPECT_EQ(visited, 4);
    EXPECT_EQ(packed.unpacked(7, 20, 4), out.block(7, 0, 20, 4));
    EXPECT_EQ(packed.leading(20, 3).unpacked(), out.topLeftCorner(20, 3));
    EXPECT_EQ(packed.alike(out).unpacked(), out);
    EXPECT_EQ(packed.bytes(), 5 * sizeof(double) + 60u * static_cast<unsigned>(fine + 5));
  }
}

TEST(PackedColumns, AreTheMatrixItselfWhereTheyAreNotInFixedPoint) {
  const Eigen::MatrixXf columns = gaussian_matrix(31, 4, 2);
  const PackedColumns<float> exact(columns), fixed = PackedColumns<float>::fixed_point(columns);
  EXPECT_EQ(exact.unpacked(), columns);
  EXPECT_EQ(exact.alike(2 * columns).column(3), 2 * columns.col(3));
  EXPECT_EQ(exact.leading(9, 2).unpacked(), columns.topLeftCorner(9, 2));
  EXPECT_LT(fixed.bytes(), 0.6 * static_cast<double>(exact.bytes()));
  Eigen::VectorXf products(4);
  exact.inner_products(columns.col(1), products);
  EXPECT_LT((products - columns.transpose() * columns.col(1)).norm(), 1e-5f);
  exact.visit(4, [&](Eigen::Index k, const auto& value) { EXPECT_EQ(value(17), columns(17, k)); });
}

TEST(PackedColumns, ZerosStayZeros) {
  EXPECT_EQ(PackedColumns<double>::fixed_point(Eigen::MatrixXd::Zero(5, 2)).unpacked(), Eigen::MatrixXd::Zero(5, 2));
  EXPECT_TRUE(PackedColumns<double>().empty());
  const auto none = PackedColumns<float>::fixed_point(Eigen::MatrixXf(5, 0));
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(none.rows(), 5);
  EXPECT_EQ(none.unpacked().rows(), 5);
  EXPECT_EQ(none.leading(3, 0).rows(), 3);
}

/// Columns as of a camera with noise of this variance, whose factor knows of it or not.
OnlineSvd factor_of(const Eigen::MatrixXf& data, double sensor_variance) {
  OnlineSvd factor(static_cast<int>(data.rows()), {.block = 8, .tolerance = 0.002, .sensor_variance = sensor_variance});
  for (Eigen::Index j = 0; j < data.cols(); ++j) factor.add(data.col(j));
  return factor;
}

double mean_square_error(const OnlineSvd& factor, const Eigen::MatrixXf& data) {
  const OnlineSvd settled = factor.settled();
  return (settled.displayed_basis() * settled.displayed_coefficients() - data).cast<double>().squaredNorm() /
         static_cast<double>(data.size());
}

TEST(PackedFactor, AddsHardlyAnythingToTheNoiseThatItWasToldOf) {
  constexpr double kNoise = 2e-5;
  const Eigen::MatrixXf truth = patch_like_matrix(450, 150, 12, 0, 5);
  const Eigen::MatrixXf data = truth + std::sqrt(static_cast<float>(kNoise)) * gaussian_matrix(450, 150, 6);
  const OnlineSvd exact = factor_of(data, 0), packed = factor_of(data, kNoise);
  EXPECT_LT(mean_square_error(packed, truth), mean_square_error(exact, truth) + 1e-3 * kNoise);
  EXPECT_NEAR(packed.row_noise() / exact.row_noise(), 1, 0.01);
  EXPECT_LT(orthogonality_loss(packed.orthonormal_basis()), 1e-4);
  const int values = 450 * (exact.rank() + exact.pending());
  EXPECT_LT(static_cast<double>(packed.bytes()), static_cast<double>(exact.bytes()) - 1.9 * values);
}

TEST(PackedFactor, IsNotChangedByLooking) {
  const Eigen::MatrixXf data = patch_like_matrix(90, 40, 6, 0.01f, 7);
  const OnlineSvd alone = factor_of(data, 2e-5);
  OnlineSvd watched(90, alone.options());
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    watched.add(data.col(j));
    watched.settled();
    watched.pending_coefficients();
    watched.displayed_coefficients();
    watched.estimate(data.col(0), {}, 1e-4);
  }
  EXPECT_EQ(watched.basis(), alone.basis());
  EXPECT_EQ(watched.coefficients(), alone.coefficients());
}

TEST(PackedFactor, TellsOfEachRowWhatItsBasisDoes) {
  const Eigen::MatrixXf data = patch_like_matrix(90, 40, 6, 0.01f, 8);
  OnlineSvd factor = factor_of(data, 2e-5);
  factor.fold();
  const Eigen::MatrixXf all = factor.basis() * factor.coefficients();
  for (int view = 0; view < 40; view += 7)
    for (int row = 0; row < 90; row += 13) EXPECT_NEAR(factor.explained(view, row), all(row, view), 1e-4);
}

}  // namespace
}  // namespace sheen
