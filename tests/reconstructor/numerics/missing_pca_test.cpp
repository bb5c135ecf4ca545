// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/missing_pca.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include "reconstructor/numerics/online_svd.h"
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

/// Each value known with this probability.
KnownValues known_at_random(int rows, int columns, double fraction, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::bernoulli_distribution shown(fraction);
  return KnownValues::NullaryExpr(rows, columns, [&] { return static_cast<std::uint8_t>(shown(engine)); });
}

/// What edges leave visible: each column hides with this probability a run of rows at one of its ends.
KnownValues known_beside_edges(int rows, int columns, double occluded, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::bernoulli_distribution hides(occluded), from_start(0.5);
  std::uniform_real_distribution<double> fraction(0.2, 0.8);
  KnownValues known = KnownValues::Ones(rows, columns);
  for (int j = 0; j < columns; ++j) {
    if (!hides(engine)) continue;
    const int hidden = static_cast<int>(fraction(engine) * rows);
    if (from_start(engine))
      known.col(j).head(hidden).setZero();
    else
      known.col(j).tail(hidden).setZero();
  }
  return known;
}

/// Not Eigen's, which gcc 12 takes to read what is not initialised.
double sum_of_logs(const VectorXd& values) {
  double sum = 0;
  for (const double value : values) sum += std::log(value);
  return sum;
}

/// -log density of what is known of a column, whose values have this covariance.
double surprise_of_column(const VectorXd& column, const MatrixXd& covariance) {
  const Eigen::LLT<MatrixXd> llt(covariance);
  return 0.5 * (static_cast<double>(column.size()) * std::log(2 * std::numbers::pi) +
                2 * sum_of_logs(llt.matrixLLT().diagonal()) + column.dot(llt.solve(column)));
}

TEST(BatchPcaMissing, WithNothingMissingIsTheBatch) {
  const MatrixXf data = patch_like_matrix(80, 40, 5, 0.01f, 6);
  const BatchPca full = batch_pca(data, 6);
  const BatchPca missing = batch_pca_missing(data, KnownValues::Ones(80, 40), 6);
  EXPECT_LT(missing.relative_error, 1.002 * full.relative_error);
  EXPECT_GE(missing.relative_error, full.relative_error * (1 - 1e-9)) << "nothing is better than the best";
}

TEST(BatchPcaMissing, CompletesALowRankMatrixExactly) {
  // Generic values of a matrix of rank 3 determine the rest.
  const MatrixXf truth = patch_like_matrix(90, 40, 2, 0, 7);
  const KnownValues known = known_at_random(90, 40, 0.5, 8);
  const MatrixXf shown = (known != 0).select(truth, std::numeric_limits<float>::quiet_NaN());
  const BatchPca pca = batch_pca_missing(shown, known, 3);
  EXPECT_LT(miss(pca, truth), 1e-4);
  EXPECT_LT(orthogonality_loss(pca.basis), 1e-12);
}

TEST(BatchPcaMissing, FillsNoisyGapsNearlyToTheNoise) {
  const MatrixXf clean = patch_like_matrix(150, 60, 4, 0, 9);
  const MatrixXf noisy = clean + 0.01f * gaussian_matrix(150, 60, 10);
  const KnownValues known = known_at_random(150, 60, 0.5, 11);
  const double full = miss(batch_pca(noisy, 5), clean);
  // Half of the values: the variance of 5 (150 + 60) parameters doubles.
  EXPECT_LT(miss(batch_pca_missing(noisy, known, 5), clean), 1.6 * full);
}

TEST(BatchPcaMissing, RowsAndColumnsOfWhichNothingIsKnownAreZero) {
  const MatrixXf data = patch_like_matrix(30, 12, 2, 0.01f, 12);
  KnownValues known = KnownValues::Ones(30, 12);
  known.row(7).setZero();
  known.col(3).setZero();
  const BatchPca pca = batch_pca_missing(data, known, 3);
  const MatrixXd model = pca.basis * pca.coefficients;
  EXPECT_LT(model.row(7).norm(), 1e-12);
  EXPECT_LT(model.col(3).norm(), 1e-12);
  EXPECT_TRUE(model.allFinite());
  EXPECT_EQ(batch_pca_missing(data, KnownValues::Zero(30, 12), 3).rank(), 0);
}

TEST(BatchPcaMissing, RefusesWhatItCannotFactorise) {
  MatrixXf data = MatrixXf::Ones(4, 3);
  EXPECT_THROW(batch_pca_missing(data, KnownValues::Ones(3, 4), 1), std::invalid_argument);
  EXPECT_THROW(batch_pca_missing(data, KnownValues::Ones(4, 3), 0), std::invalid_argument);
  EXPECT_THROW(batch_pca_missing(data, KnownValues::Ones(4, 3), 1, std::vector<double>{1, 0, 1}),
               std::invalid_argument);
  data(1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(batch_pca_missing(data, KnownValues::Ones(4, 3), 1), std::invalid_argument);
}

TEST(BatchPcaImputed, WithNothingMissingIsTheBatchToTheLastDigits) {
  const MatrixXf data = patch_like_matrix(80, 30, 8, 0.01f, 13);
  const std::vector<double> weights = {[] {
    std::vector<double> w;
    for (int j = 0; j < 30; ++j) w.push_back(1 + j % 3);
    return w;
  }()};
  const BatchPca exact = batch_pca(data, 4, weights);
  const BatchPca imputed = batch_pca_imputed(data, KnownValues::Ones(80, 30), 4, 8, weights);
  EXPECT_LT((imputed.basis * imputed.coefficients - exact.basis * exact.coefficients).norm(),
            1e-9 * data.cast<double>().norm());
  EXPECT_NEAR(imputed.relative_error, exact.relative_error, 1e-9);
}

TEST(BatchPcaImputed, TermsThatAreLeftOutHelpToImpute) {
  // Of rank 6, three terms of which are kept: those of the matrix that the six complete.
  const MatrixXf truth = patch_like_matrix(90, 60, 5, 0, 14);
  const KnownValues known = known_at_random(90, 60, 0.6, 15);
  const BatchPca best = batch_pca(truth, 3);
  EXPECT_LT(miss(batch_pca_imputed(truth, known, 3, 6), truth), 1.2 * best.relative_error);
  const auto outside = [&](const BatchPca& pca) {
    return (best.basis - pca.basis * (pca.basis.transpose() * best.basis)).norm();
  };
  EXPECT_LT(outside(batch_pca_imputed(truth, known, 3, 6)), 0.2 * outside(batch_pca_imputed(truth, known, 3, 3)));
}

TEST(Surprise, OfAPcaIsTippingsAndBishopsClosedForm) {
  const int rows = 30, n = 50, rank = 4;
  const MatrixXf data = patch_like_matrix(rows, n, 6, 0.05f, 16);
  const BatchPca pca = batch_pca(data, rank);
  const VectorXd variances = pca.singular_values.cwiseAbs2() / n;
  const double noise = variances.tail(rows - rank).mean();
  const double closed = 0.5 * (rows * std::log(2 * std::numbers::pi) + sum_of_logs(variances.head(rank)) +
                               (rows - rank) * std::log(noise) + rows);
  EXPECT_NEAR(surprise(data, KnownValues::Ones(rows, n), pca.basis), closed / rows, 1e-6);
}

TEST(Surprise, IsTheLeastOverAllCovariancesAndNoises) {
  const int rows = 20, n = 30, rank = 2;
  const MatrixXf data = patch_like_matrix(rows, n, 3, 0.1f, 17);
  const KnownValues known = known_beside_edges(rows, n, 0.7, 18);
  const MatrixXd basis = batch_pca(data, rank).basis;
  const double least = surprise(data, known, basis);
  const VectorXd variances = (basis.transpose() * data.cast<double>()).rowwise().squaredNorm() / n;
  double nearest = std::numeric_limits<double>::infinity();
  for (const double first : {0.5, 0.8, 0.9, 1.0, 1.1, 1.25, 2.0})
    for (const double second : {0.5, 0.8, 0.9, 1.0, 1.1, 1.25, 2.0})
      for (double deviation = 0.05; deviation < 0.4; deviation *= 1.1) {
        const MatrixXd covariance =
            basis * VectorXd{{first * variances[0], second * variances[1]}}.asDiagonal() * basis.transpose() +
            deviation * deviation * MatrixXd::Identity(rows, rows);
        double sum = 0, values = 0;
        for (int j = 0; j < n; ++j) {
          std::vector<int> shown;
          for (int i = 0; i < rows; ++i)
            if (known(i, j)) shown.push_back(i);
          const VectorXd column = data.cast<double>()(shown, j);
          sum += surprise_of_column(column, covariance(shown, shown));
          values += static_cast<double>(shown.size());
        }
        nearest = std::min(nearest, sum / values);
      }
  EXPECT_GE(nearest, least - 1e-9);
  EXPECT_LT(nearest, least + 0.02) << "the grid comes near it";
}

TEST(Surprise, OfTheBatchIsNeverMoreThanOfAnyOnlineFactorization) {
  // The reference of figures 8 and 11: whatever the masks, the weights and the order, no online basis is ahead of it.
  constexpr int kRows = 90, kViews = 40, kRank = 4;
  int compared = 0;
  for (const double occluded : {0.0, 0.5, 0.8, 1.0})
    for (std::uint32_t seed = 0; seed < 5; ++seed) {
      const MatrixXf data = patch_like_matrix(kRows, kViews, 7, 0.05f, 100 + 50 * seed);
      const KnownValues known = known_beside_edges(kRows, kViews, occluded, 20 + seed);
      std::vector<double> weights;
      for (int j = 0; j < kViews; ++j) weights.push_back(std::pow(known.col(j).cast<double>().mean(), 2));
      const double batch =
          surprise(data, known, batch_pca_missing(data, known, kRank, weights, {.convergence = 1e-7}).basis, weights);
      for (const int inside : {kRank, 2 * kRank}) {
        OnlineSvd factor(kRows, {.max_rank = kRank, .internal_rank = inside, .tolerance = 0});
        for (int j = 0; j < kViews; ++j)
          factor.add(data.col(j), {known.col(j).data(), static_cast<std::size_t>(kRows)},
                     weights[static_cast<std::size_t>(j)]);
        const double online = surprise(data, known, factor.settled().displayed_basis().cast<double>(), weights);
        EXPECT_GE(online, batch - 1e-6) << occluded << " occluded, seed " << seed << ", " << inside << " terms inside";
        EXPECT_LT(online, batch + 1) << "of the same patch";
        ++compared;
      }
    }
  EXPECT_EQ(compared, 40);
}

TEST(Surprise, OfTheBatchIsTheLeastAtAGivenNoiseToo) {
  constexpr int kRows = 90, kViews = 20, kRank = 8;
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    const MatrixXf data = patch_like_matrix(kRows, kViews, 7, 0.05f, 300 + 50 * seed);
    const KnownValues known = known_beside_edges(kRows, kViews, 0.8, 40 + seed);
    OnlineSvd factor(kRows, {.max_rank = kRank, .internal_rank = kRank, .tolerance = 0});
    for (int j = 0; j < kViews; ++j) factor.add(data.col(j), {known.col(j).data(), static_cast<std::size_t>(kRows)});
    const OnlineSvd online = factor.settled();
    const double noise = online.row_noise();
    const BatchPca batch = batch_pca_missing(data, known, kRank, {}, {.convergence = 1e-7, .noise = noise});
    const double least = surprise(data, known, batch.basis, {}, noise);
    EXPECT_GE(surprise(data, known, online.displayed_basis().cast<double>(), {}, noise), least - 1e-6) << seed;
    EXPECT_LE(surprise(data, known, batch.basis), least) << "the most probable noise is more probable";
  }
}

}  // namespace
}  // namespace sheen
