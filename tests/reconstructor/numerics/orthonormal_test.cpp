// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/orthonormal.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Orthonormalised of_columns(const MatrixXd& p, double smallest_pivot = 1e-10) {
  return orthonormalise(p.transpose() * p, p.colwise().squaredNorm().transpose(), smallest_pivot);
}

MatrixXd random_rotation(int size, unsigned seed) {
  return gaussian_matrix(size, size, seed).cast<double>().householderQr().householderQ();
}

TEST(Orthonormalise, ColumnsOfAnySizeAreTheDirectionsTimesTheCoefficients) {
  MatrixXd p = gaussian_matrix(50, 8, 1).cast<double>();
  for (int j = 0; j < 8; ++j) p.col(j) *= std::pow(10.0, 4 * j - 14);
  const Orthonormalised result = of_columns(p);
  ASSERT_EQ(result.to_directions.cols(), 8);
  const MatrixXd r = p * result.to_directions;
  EXPECT_LT(orthogonality_loss(r), 1e-13);
  for (int j = 0; j < 8; ++j)
    EXPECT_LT((r * result.coefficients.col(j) - p.col(j)).norm(), 1e-13 * p.col(j).norm()) << j;
}

TEST(Orthonormalise, WhatTheOthersExplainAndWhatIsZeroGivesNoDirection) {
  MatrixXd p = gaussian_matrix(50, 6, 2).cast<double>();
  p.col(1).setZero();
  p.col(4) = 1e6 * p.col(0) - p.col(3);
  const Orthonormalised result = of_columns(p);
  ASSERT_EQ(result.to_directions.cols(), 4);
  const MatrixXd r = p * result.to_directions;
  EXPECT_LT(orthogonality_loss(r), 1e-9);
  EXPECT_LT((r * result.coefficients - p).norm(), 1e-5 * p.norm());
  EXPECT_EQ(result.coefficients.col(1), VectorXd::Zero(4));
  EXPECT_EQ(result.to_directions.row(1), VectorXd::Zero(4).transpose());
}

TEST(Orthonormalise, NothingGivesNothing) {
  EXPECT_EQ(of_columns(MatrixXd::Zero(50, 3)).to_directions.cols(), 0);
  EXPECT_EQ(of_columns(MatrixXd::Zero(50, 0)).coefficients.size(), 0);
}

TEST(AligningRotation, TurnsAFrameThatWasOnlyRotatedBack) {
  for (const int displayed : {1, 2, 7}) {
    MatrixXd leading = MatrixXd::Zero(displayed + 5, displayed);
    leading.topRows(displayed) = random_rotation(displayed, 3);
    const MatrixXd turned = leading * aligning_rotation(leading, displayed);
    EXPECT_LT((turned - MatrixXd::Identity(displayed + 5, displayed)).norm(), 1e-13) << displayed;
  }
}

TEST(AligningRotation, ASpanThatHardlyTurnsMovesTheFrameHardly) {
  const MatrixXd tilt = MatrixXd::Identity(12, 12) + 1e-3 * gaussian_matrix(12, 12, 4).cast<double>();
  const MatrixXd span = tilt.householderQr().householderQ() * MatrixXd::Identity(12, 6);
  const MatrixXd leading = span * random_rotation(6, 5);
  const MatrixXd rotation = aligning_rotation(leading, 6);
  EXPECT_LT(orthogonality_loss(rotation), 1e-13);
  EXPECT_LT((leading * rotation - MatrixXd::Identity(12, 6)).norm(), 0.02);
}

TEST(AligningRotation, NewTermsComeBehindTheOldAndFewerTermsKeepTheirPlaces) {
  for (const int old_displayed : {3, 9}) {
    const MatrixXd leading = random_rotation(10, 6).leftCols(6);
    const MatrixXd rotation = aligning_rotation(leading, old_displayed);
    EXPECT_EQ(rotation.rows(), 6);
    EXPECT_LT(orthogonality_loss(rotation), 1e-13);
    const MatrixXd turned = leading * rotation;
    for (int i = 0; i < std::min(6, old_displayed); ++i) EXPECT_GE(turned(i, i), 0) << i;
  }
}

}  // namespace
}  // namespace sheen
