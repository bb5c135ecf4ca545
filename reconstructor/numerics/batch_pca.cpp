// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/batch_pca.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
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

}  // namespace

BatchPca batch_pca_in_double(const MatrixXd& columns, int rank, std::span<const double> weights) {
  if (rank < 1) throw std::invalid_argument("batch_pca: rank " + std::to_string(rank) + " is less than 1");
  if (!columns.allFinite()) throw std::invalid_argument("batch_pca: a value is not finite");
  return factorize(columns, rank, weights_of(weights, columns.cols()).cwiseSqrt());
}

BatchPca batch_pca(const Eigen::MatrixXf& columns, int rank, std::span<const double> weights) {
  return batch_pca_in_double(columns.cast<double>(), rank, weights);
}

}  // namespace sheen
