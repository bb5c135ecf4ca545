// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/batch_pca.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <limits>
#include <stdexcept>
#include <vector>

#include "tests/support/matchers.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXd;

double miss(const BatchPca& pca, const MatrixXf& truth) {
  const MatrixXd t = truth.cast<double>();
  return (pca.basis * pca.coefficients - t).norm() / t.norm();
}

TEST(BatchPca, ADiagonalMatrixKeepsItsLargestEntries) {
  MatrixXf diagonal = MatrixXf::Zero(7, 4);
  diagonal.diagonal() << 2, 5, 3, 4;
  const BatchPca pca = batch_pca(diagonal, 2);
  EXPECT_TRUE(pca.singular_values.isApprox(VectorXd{{5, 4, 3, 2}}, 1e-14));
  EXPECT_NEAR(pca.relative_error, std::sqrt((9.0 + 4) / (25 + 16 + 9 + 4)), 1e-14);
  EXPECT_NEAR(std::abs(pca.basis(1, 0)), 1, 1e-14);
  EXPECT_NEAR(std::abs(pca.coefficients(1, 3)), 4, 1e-14);
}

TEST(BatchPca, AgreesWithAnSvdWhetherTallOrWide) {
  for (const bool wide : {false, true}) {
    MatrixXf data = patch_like_matrix(60, 25, 8, 0.01f, 1);
    if (wide) data.transposeInPlace();
    const Eigen::BDCSVD<MatrixXd> svd(data.cast<double>(), Eigen::ComputeThinU | Eigen::ComputeThinV);
    const int rank = 6;
    const BatchPca pca = batch_pca(data, rank);
    EXPECT_LT((pca.singular_values - svd.singularValues()).cwiseAbs().maxCoeff(), 1e-12 * svd.singularValues()[0]);
    const MatrixXd best = svd.matrixU().leftCols(rank) * svd.singularValues().head(rank).asDiagonal() *
                          svd.matrixV().leftCols(rank).transpose();
    EXPECT_LT((pca.basis * pca.coefficients - best).norm(), 1e-10 * best.norm());
    EXPECT_NEAR(pca.relative_error, svd.singularValues().tail(25 - rank).norm() / svd.singularValues().norm(), 1e-10);
    EXPECT_LT(orthogonality_loss(pca.basis), 1e-13);
  }
}

TEST(BatchPca, WeightsCountAColumnSeveralTimes) {
  const MatrixXf data = patch_like_matrix(40, 3, 3, 0.1f, 2);
  MatrixXf repeated(40, 6);
  repeated << data.col(0), data.col(1), data.col(1), data.col(1), data.col(2), data.col(2);
  const BatchPca weighted = batch_pca(data, 2, std::vector<double>{1, 3, 2});
  const BatchPca plain = batch_pca(repeated, 2);
  EXPECT_LT((weighted.basis * weighted.coefficients.col(1) - plain.basis * plain.coefficients.col(2)).norm(), 1e-11);
  EXPECT_NEAR(weighted.relative_error, plain.relative_error, 1e-12);
}

TEST(BatchPca, HasNoMoreTermsThanTheData) {
  const MatrixXf data = gaussian_matrix(30, 1, 3) * gaussian_matrix(1, 8, 4);
  EXPECT_EQ(batch_pca(data.leftCols(1), 5).rank(), 1);
  EXPECT_LE(batch_pca(data, 20).rank(), 8);
  const BatchPca nothing = batch_pca(MatrixXf::Zero(30, 8), 3);
  EXPECT_EQ(nothing.rank(), 0);
  EXPECT_EQ(nothing.relative_error, 0);
  EXPECT_EQ((nothing.basis * nothing.coefficients).norm(), 0);
}

TEST(BatchPca, ScaleDoesNotMatter) {
  const MatrixXf data = patch_like_matrix(50, 20, 6, 0.01f, 5);
  const BatchPca plain = batch_pca(data, 4);
  for (const float scale : {1e-30f, 1e30f}) {
    const BatchPca scaled = batch_pca(scale * data, 4);
    EXPECT_NEAR(scaled.relative_error, plain.relative_error, 1e-6) << scale;
    EXPECT_LT(miss(scaled, scale * data), 1.000001 * plain.relative_error) << scale;
  }
}

TEST(BatchPca, RefusesWhatItCannotFactorise) {
  MatrixXf data = MatrixXf::Ones(4, 3);
  EXPECT_THROW(batch_pca(data, 0), std::invalid_argument);
  EXPECT_THROW(batch_pca(data, 1, std::vector<double>{1, 1}), std::invalid_argument);
  EXPECT_THROW(batch_pca(data, 1, std::vector<double>{1, 0, 1}), std::invalid_argument);
  data(1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(batch_pca(data, 1), std::invalid_argument);
}

}  // namespace
}  // namespace sheen
