// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/imputation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>

#include "reconstructor/numerics/online_svd.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;
using Eigen::VectorXf;

struct Case {
  MatrixXd basis = Eigen::HouseholderQR<MatrixXd>(gaussian_matrix(30, 4, 1).cast<double>()).householderQ() *
                   MatrixXd::Identity(30, 4);
  MatrixXd prior = VectorXd{{9, 4, 1, 0.25}}.asDiagonal();
  VectorXd column = gaussian_matrix(30, 1, 2).cast<double>();

  VectorXd from_first(int rows) const {
    const MatrixXd known = basis.topRows(rows);
    return least_squares_coefficients(known.transpose() * known, known.transpose() * column.head(rows), prior);
  }
};

TEST(LeastSquares, OfAllRowsIsTheProjection) {
  const Case c;
  EXPECT_LT((c.from_first(30) - c.basis.transpose() * c.column).norm(), 1e-9);
}

TEST(LeastSquares, OfEnoughRowsIsTheirLeastSquares) {
  const Case c;
  const VectorXd exact = c.basis.topRows(12).colPivHouseholderQr().solve(c.column.head(12));
  EXPECT_LT((c.from_first(12) - exact).norm(), 1e-6 * exact.norm());
}

TEST(LeastSquares, OfTooFewRowsHasTheLeastMahalanobisNorm) {
  const Case c;
  const MatrixXd known = c.basis.topRows(2);
  const VectorXd exact =
      c.prior * known.transpose() * (known * c.prior * known.transpose()).inverse() * c.column.head(2);
  const VectorXd y = c.from_first(2);
  EXPECT_LT((known * y - c.column.head(2)).norm(), 1e-6) << "both rows are met";
  EXPECT_LT((y - exact).norm(), 1e-4 * exact.norm());
}

TEST(LeastSquares, OfNoRowIsZero) {
  EXPECT_EQ(Case().from_first(0).norm(), 0);
}

TEST(LeastSquares, AFactorFillsAHalfHiddenColumnWithIt) {
  const MatrixXf data = patch_like_matrix(60, 31, 3, 0.01f, 3);
  const OnlineSvdOptions options{.max_rank = 4, .tolerance = 0, .imputation = Imputation::kLeastSquares};
  OnlineSvd factor(60, options);
  for (int j = 0; j < 30; ++j) factor.add(data.col(j));
  factor.fold();
  std::vector<std::uint8_t> known(60, 1);
  std::fill(known.begin() + 30, known.end(), 0);
  OnlineSvd filled = factor;
  VectorXf column = data.col(30);
  const VectorXf y = factor.basis().topRows(30).colPivHouseholderQr().solve(column.head(30));
  column.tail(30) = factor.basis().bottomRows(30) * y;
  factor.add(column);
  filled.add(data.col(30), known);
  const OnlineSvd a = factor.settled(), b = filled.settled();
  EXPECT_LT((a.basis() * a.coefficients() - b.basis() * b.coefficients()).norm(), 1e-4 * data.norm());
}

TEST(LeastSquares, ChangesNothingWhereAllIsVisible) {
  const MatrixXf data = patch_like_matrix(60, 40, 6, 0.01f, 4);
  OnlineSvd ours(60, {.max_rank = 4, .tolerance = 0});
  OnlineSvd theirs(60, {.max_rank = 4, .tolerance = 0, .imputation = Imputation::kLeastSquares});
  for (int j = 0; j < 40; ++j) {
    ours.add(data.col(j));
    theirs.add(data.col(j));
  }
  EXPECT_EQ(MatrixXf(ours.settled().basis()), MatrixXf(theirs.settled().basis()));
  EXPECT_EQ(ours.settled().coefficients(), theirs.settled().coefficients());
}

}  // namespace
}  // namespace sheen
