// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/batch_pca.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace sheen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The Gram matrix holds squares: below the root of its rounding a singular value is noise.
constexpr double kNoise = 1e-7;

VectorXd weights_of(std::span<const double> weights, Index columns) {
  if (weights.empty()) return VectorXd::Ones(columns);
  if (static_cast<Index>(weights.size()) != columns)
    throw std::invalid_argument("batch_pca: " + std::to_string(weights.size()) + " weights for " +
                                std::to_string(columns) + " columns");
  for (const double w : weights)
    if (!(w > 0) || !std::isfinite(w)) throw std::invalid_argument("batch_pca: a weight is not positive");
  return Eigen::Map<const VectorXd>(weights.data(), columns);
}

void check_rank(int rank) {
  if (rank < 1) throw std::invalid_argument("batch_pca: rank " + std::to_string(rank) + " is less than 1");
}

/// Factorization of a finite matrix whose columns count `root` squared times each.
BatchPca factorize(const MatrixXd& columns, int rank, const VectorXd& root) {
  const Index rows = columns.rows(), n = columns.cols();
  BatchPca result;
  const MatrixXd weighted = columns * root.asDiagonal();
  const bool tall = rows >= n;
  const Index side = std::min(rows, n);
  MatrixXd gram = MatrixXd::Zero(side, side);
  if (tall)
    gram.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
  else
    gram.selfadjointView<Eigen::Lower>().rankUpdate(weighted);
  const double energy = gram.trace();
  if (!(energy > 0)) {
    result.basis.resize(rows, 0);
    result.coefficients.resize(0, n);
    result.singular_values = VectorXd::Zero(side);
    return result;
  }
  gram /= energy;  // the solver's thresholds are absolute
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(gram);
  const VectorXd values = eigen.eigenvalues().reverse().cwiseMax(0);
  result.singular_values = values.cwiseSqrt() * std::sqrt(energy);

  Index kept = 0;
  while (kept < std::min<Index>(rank, side) && values[kept] > kNoise * kNoise * values[0]) ++kept;
  const MatrixXd vectors = eigen.eigenvectors().rightCols(kept).rowwise().reverse();
  MatrixXd basis = vectors;
  if (tall) basis = weighted * vectors * values.head(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  // What squaring took from the orthonormality of the weak directions is given back; signs stay.
  const Eigen::HouseholderQR<MatrixXd> qr(basis);
  const VectorXd signs = qr.matrixQR().diagonal().head(kept).cwiseSign();
  result.basis = qr.householderQ() * MatrixXd::Identity(rows, kept) * signs.asDiagonal();
  result.coefficients = result.basis.transpose() * columns;
  result.relative_error =
      (weighted - result.basis * (result.coefficients * root.asDiagonal())).norm() / weighted.norm();
  return result;
}

/// Mean of what is known of each row, where a value is missing.
MatrixXd filled_with_means(const MatrixXd& values, const MatrixXd& known, const VectorXd& weights) {
  const VectorXd count = (known * weights).cwiseMax(std::numeric_limits<double>::min());
  const VectorXd mean = (values * weights).cwiseQuotient(count);
  return values + mean.asDiagonal() * (MatrixXd::Ones(known.rows(), known.cols()) - known);
}

/// k^2 x count: v v^T of each column v, flattened.
MatrixXd outer_products(const MatrixXd& vectors) {
  const Index k = vectors.rows();
  MatrixXd products(k * k, vectors.cols());
  for (Index j = 0; j < vectors.cols(); ++j)
    Eigen::Map<MatrixXd>(products.col(j).data(), k, k) = vectors.col(j) * vectors.col(j).transpose();
  return products;
}

/// Probabilistic PCA by expectation maximisation.
struct Expectation {
  const MatrixXd& values;  ///< rows x n, zero where missing
  const MatrixXd& known;   ///< rows x n: 1 or 0
  const VectorXd& weights;
  MatrixXd directions;  ///< W^T, k x rows
  MatrixXd scores;      ///< E[x], k x n
  double noise;         ///< variance of a value
  double scale;         ///< mean square of the known values

  /// Posterior of the scores; returns E[x x^T] of each column, flattened.
  MatrixXd expect() {
    const Index k = directions.rows(), n = values.cols();
    const MatrixXd normal = outer_products(directions) * known;
    const MatrixXd right = directions * values;
    scores.resize(k, n);
    MatrixXd moments(k * k, n);
    for (Index j = 0; j < n; ++j) {
      MatrixXd m = Eigen::Map<const MatrixXd>(normal.col(j).data(), k, k);
      m.diagonal().array() += noise;
      const Eigen::LLT<MatrixXd> llt(m);
      scores.col(j) = llt.solve(right.col(j));
      Eigen::Map<MatrixXd>(moments.col(j).data(), k, k) =
          scores.col(j) * scores.col(j).transpose() + noise * llt.solve(MatrixXd::Identity(k, k));
    }
    return moments;
  }

  /// The directions and the noise that are most probable given the posterior.
  void maximise(const MatrixXd& moments) {
    const Index k = directions.rows();
    const MatrixXd normal = (moments * weights.asDiagonal()) * known.transpose();  // k^2 x rows
    const MatrixXd right = (scores * weights.asDiagonal()) * values.transpose();
    double explained = 0;
    for (Index i = 0; i < values.rows(); ++i) {
      MatrixXd a = Eigen::Map<const MatrixXd>(normal.col(i).data(), k, k);
      a.diagonal().array() += std::numeric_limits<double>::min();  // a row of which nothing is known
      directions.col(i) = a.ldlt().solve(right.col(i));
      explained += directions.col(i).dot(right.col(i));
    }
    const double energy = (values.cwiseAbs2() * weights).sum();
    const double count = (known * weights).sum();
    noise = std::max((energy - explained) / count, 1e-14 * scale);
  }
};

}  // namespace

BatchPca batch_pca(const Eigen::MatrixXf& columns, int rank, std::span<const double> weights) {
  check_rank(rank);
  if (!columns.allFinite()) throw std::invalid_argument("batch_pca: a value is not finite");
  return factorize(columns.cast<double>(), rank, weights_of(weights, columns.cols()).cwiseSqrt());
}

BatchPca batch_pca_missing(const Eigen::MatrixXf& columns, const KnownValues& known, int rank,
                           std::span<const double> weights, const MissingPcaOptions& options) {
  check_rank(rank);
  if (known.rows() != columns.rows() || known.cols() != columns.cols())
    throw std::invalid_argument("batch_pca: known values are " + std::to_string(known.rows()) + " x " +
                                std::to_string(known.cols()) + ", columns " + std::to_string(columns.rows()) + " x " +
                                std::to_string(columns.cols()));
  const VectorXd w = weights_of(weights, columns.cols());
  const VectorXd root = w.cwiseSqrt();
  const MatrixXd is_known = (known != 0).cast<double>().matrix();
  const MatrixXd values = (known != 0).select(columns.cast<double>(), 0.0);
  if (!values.allFinite()) throw std::invalid_argument("batch_pca: a known value is not finite");

  BatchPca start = factorize(filled_with_means(values, is_known, w), rank, root);
  const double energy = (values.cwiseAbs2() * w).sum();
  if (!(energy > 0)) return start;
  const double count = (is_known * w).sum();
  const MatrixXd first_miss = is_known.cwiseProduct(values - start.basis * start.coefficients);
  // Directions carry the standard deviation of their coefficients: the scores are standard normal.
  const VectorXd deviation = ((start.coefficients.cwiseAbs2() * w) / w.sum()).cwiseSqrt();
  const double scale = energy / count;
  Expectation em{values, is_known,
                 w,      deviation.asDiagonal() * start.basis.transpose(),
                 {},     std::max((first_miss.cwiseAbs2() * w).sum() / count, 1e-14 * scale),
                 scale};
  for (int i = 0; i < options.max_iterations; ++i) {
    const double before = em.noise;
    em.maximise(em.expect());
    if (std::abs(em.noise - before) <= options.convergence * before) break;
  }
  em.expect();

  // In singular order, where the product W x counts and not how it is split.
  BatchPca result = factorize(em.directions.transpose() * em.scores, rank, root);
  const MatrixXd miss = is_known.cwiseProduct(values - result.basis * result.coefficients);
  result.relative_error = std::sqrt((miss.cwiseAbs2() * w).sum() / energy);
  return result;
}

}  // namespace sheen
