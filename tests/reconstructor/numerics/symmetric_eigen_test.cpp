// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/symmetric_eigen.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <random>

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd gaussian(int rows, int cols, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(engine); });
}

/// A matrix with these eigenvalues and random eigenvectors.
MatrixXd with_eigenvalues(const VectorXd& values, std::uint32_t seed) {
  const auto size = static_cast<int>(values.size());
  const MatrixXd q = Eigen::HouseholderQR<MatrixXd>(gaussian(size, size, seed)).householderQ();
  const MatrixXd a = q * values.asDiagonal() * q.transpose();
  return 0.5 * (a + a.transpose());
}

/// Descending, orthonormal, and A V = V diag(values), all to rounding of the norm.
void expect_decomposes(const MatrixXd& a) {
  const SymmetricEigen eigen = symmetric_eigen(a);
  const Eigen::Index size = a.rows();
  ASSERT_EQ(eigen.values.size(), size);
  ASSERT_EQ(eigen.vectors.rows(), size);
  ASSERT_EQ(eigen.vectors.cols(), size);
  const double tolerance = 1e-15 * static_cast<double>(size + 4);
  for (Eigen::Index i = 0; i + 1 < size; ++i) EXPECT_GE(eigen.values[i], eigen.values[i + 1]);
  EXPECT_LE((eigen.vectors.transpose() * eigen.vectors - MatrixXd::Identity(size, size)).norm(), 4 * tolerance);
  const double scale = a.size() > 0 ? a.cwiseAbs().maxCoeff() : 0;  // whose squares may overflow
  if (scale == 0) {
    EXPECT_EQ(eigen.values.norm(), 0);
    return;
  }
  const MatrixXd left = a / scale * eigen.vectors, right = eigen.vectors * (eigen.values / scale).asDiagonal();
  EXPECT_LE((left - right).norm(), tolerance * (a / scale).norm());
}

TEST(SymmetricEigen, SecondDifferencesHaveTheKnownEigenvalues) {
  for (const int size : {1, 2, 3, 8, 17, 36, 64}) {
    MatrixXd a = 2 * MatrixXd::Identity(size, size);
    a.diagonal(1).setConstant(-1);
    a.diagonal(-1).setConstant(-1);
    const SymmetricEigen eigen = symmetric_eigen(a);
    for (int k = 0; k < size; ++k)
      EXPECT_NEAR(eigen.values[k], 2 + 2 * std::cos((k + 1) * std::numbers::pi / (size + 1)), 1e-14);
    expect_decomposes(a);
  }
}

TEST(SymmetricEigen, EigenvaluesAreThoseThatTheMatrixWasMadeOf) {
  for (const int size : {5, 24, 36}) {
    VectorXd graded(size);
    for (int i = 0; i < size; ++i) graded[i] = std::pow(10, -12.0 * i / size);
    EXPECT_LE((symmetric_eigen(with_eigenvalues(graded, size)).values - graded).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(SymmetricEigen, NothingAndScalars) {
  EXPECT_EQ(symmetric_eigen(MatrixXd(0, 0)).values.size(), 0);
  for (const double value : {0.0, 3.0, -3.0}) {
    EXPECT_EQ(symmetric_eigen(MatrixXd::Constant(1, 1, value)).values[0], value);
    expect_decomposes(MatrixXd::Constant(1, 1, value));
  }
}

TEST(SymmetricEigen, DiagonalsZerosAndOnes) {
  expect_decomposes(MatrixXd::Zero(12, 12));
  expect_decomposes(MatrixXd::Identity(12, 12));
  expect_decomposes(MatrixXd::Ones(12, 12));
  expect_decomposes(VectorXd::LinSpaced(20, -1, 1).asDiagonal());
}

TEST(SymmetricEigen, PairsOfOppositeEigenvalues) {
  for (const int size : {4, 5, 8, 21, 40}) {
    MatrixXd path = MatrixXd::Zero(size, size);
    path.diagonal(1).setOnes();
    path.diagonal(-1).setOnes();
    expect_decomposes(path);
    MatrixXd mirror = MatrixXd::Zero(size, size);
    for (int i = 0; i < size; ++i) mirror(i, size - 1 - i) = 1;
    expect_decomposes(mirror);
  }
}

TEST(SymmetricEigen, ClustersAndRankDeficiency) {
  for (const int size : {8, 24, 36, 50}) {
    VectorXd values = VectorXd::Ones(size);
    values.tail(size / 2).setConstant(1e-9);
    expect_decomposes(with_eigenvalues(values, size));
    for (int i = 0; i < size; ++i) values[i] = 1 + 1e-13 * i;
    expect_decomposes(with_eigenvalues(values, size));
    const MatrixXd thin = gaussian(size, 3, size);
    expect_decomposes(thin * thin.transpose());
  }
}

TEST(SymmetricEigen, AnyScale) {
  const MatrixXd factor = gaussian(20, 20, 1);
  const MatrixXd a = factor * factor.transpose();
  for (const double scale : {1e-310, 1e-300, 1e-150, 1e150, 1e300}) expect_decomposes(scale * a);
}

TEST(SymmetricEigen, RandomMatricesOfWholeNumbers) {
  std::mt19937 engine(7);
  std::uniform_int_distribution<int> number(-1, 1), size(1, 40);
  for (int trial = 0; trial < 3000; ++trial) {
    const int n = size(engine);
    const MatrixXd half = MatrixXd::NullaryExpr(n, n, [&] { return number(engine); });
    expect_decomposes(half + half.transpose());
  }
}

}  // namespace
}  // namespace sheen
