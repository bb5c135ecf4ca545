// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/missing_pca.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "reconstructor/numerics/imputation.h"

namespace sheen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rows that are known in the same columns. The noise is the same in all of them, so they can be rotated into each
/// other without changing what is probable: as many rotated rows as there are columns hold all that is known.
struct RowGroup {
  std::vector<Index> rows;     ///< of the matrix
  std::vector<Index> columns;  ///< in which they are known
  Index first = 0, count = 0;  ///< rows of the compact matrix
  MatrixXd rotation;           ///< rows x count, orthonormal columns; empty where the rows are kept as they are
};

/// The known values with fewer rows, of the same likelihood.
struct Compact {
  std::vector<RowGroup> groups;
  MatrixXd values;     ///< compact rows x n, zero where missing
  MatrixXd known;      ///< groups x n: 1 or 0
  VectorXd row_count;  ///< for each group: rows of the matrix
  VectorXd weights;    ///< n
  double energy = 0;   ///< weighted sum of squares of the known values
  double count = 0;    ///< weighted number of known values

  Index rows() const { return values.rows(); }
  VectorXd known_in_column() const { return known.transpose() * row_count; }

  /// Of a basis of the compact rows: one of all rows.
  MatrixXd expand(const MatrixXd& compact, Index rows) const {
    MatrixXd expanded = MatrixXd::Zero(rows, compact.cols());
    for (const RowGroup& group : groups) {
      const auto part = compact.middleRows(group.first, group.count);
      if (group.rotation.size() > 0)
        expanded(group.rows, Eigen::all) = group.rotation * part;
      else
        expanded(group.rows, Eigen::all) = part;
    }
    return expanded;
  }
  /// For each group, all rows its own: 1 or 0 for each compact row and column.
  MatrixXd known_rows() const {
    MatrixXd rows_known(rows(), known.cols());
    for (std::size_t g = 0; g < groups.size(); ++g)
      rows_known.middleRows(groups[g].first, groups[g].count) =
          known.row(static_cast<Index>(g)).replicate(groups[g].count, 1);
    return rows_known;
  }
};

std::vector<RowGroup> row_groups(const KnownValues& known) {
  std::vector<RowGroup> groups;
  std::map<std::string, std::size_t> of_pattern;
  std::string pattern(static_cast<std::size_t>(known.cols()), 0);
  for (Index i = 0; i < known.rows(); ++i) {
    for (Index j = 0; j < known.cols(); ++j) pattern[static_cast<std::size_t>(j)] = known(i, j) != 0;
    const auto [found, is_new] = of_pattern.try_emplace(pattern, groups.size());
    if (is_new) {
      groups.emplace_back();
      for (Index j = 0; j < known.cols(); ++j)
        if (known(i, j) != 0) groups.back().columns.push_back(j);
    }
    groups[found->second].rows.push_back(i);
  }
  std::erase_if(groups, [](const RowGroup& group) { return group.columns.empty(); });
  return groups;
}

VectorXd weights_of(std::span<const double> weights, Index columns) {
  if (weights.empty()) return VectorXd::Ones(columns);
  if (static_cast<Index>(weights.size()) != columns)
    throw std::invalid_argument("missing_pca: " + std::to_string(weights.size()) + " weights for " +
                                std::to_string(columns) + " columns");
  if (!std::all_of(weights.begin(), weights.end(), [](double w) { return w > 0 && std::isfinite(w); }))
    throw std::invalid_argument("missing_pca: a weight is not positive");
  return Eigen::Map<const VectorXd>(weights.data(), columns);
}

Compact compact(const Eigen::MatrixXf& columns, const KnownValues& known, std::span<const double> weights) {
  if (known.rows() != columns.rows() || known.cols() != columns.cols())
    throw std::invalid_argument("missing_pca: known values are " + std::to_string(known.rows()) + " x " +
                                std::to_string(known.cols()) + ", columns " + std::to_string(columns.rows()) + " x " +
                                std::to_string(columns.cols()));
  const Index n = columns.cols();
  Compact result{.groups = row_groups(known), .weights = weights_of(weights, n)};
  const auto groups = static_cast<Index>(result.groups.size());
  result.known = MatrixXd::Zero(groups, n);
  result.row_count.resize(groups);
  Index rows = 0;
  for (RowGroup& group : result.groups) {
    group.first = rows;
    group.count = static_cast<Index>(std::min(group.rows.size(), group.columns.size()));
    rows += group.count;
  }
  result.values = MatrixXd::Zero(rows, n);
  for (Index g = 0; g < groups; ++g) {
    RowGroup& group = result.groups[static_cast<std::size_t>(g)];
    const auto all = static_cast<Index>(group.rows.size());
    result.row_count[g] = static_cast<double>(all);
    MatrixXd values = columns(group.rows, group.columns).cast<double>();
    if (!values.allFinite()) throw std::invalid_argument("missing_pca: a known value is not finite");
    if (group.count < all) {
      const Eigen::HouseholderQR<MatrixXd> qr(values);
      group.rotation = qr.householderQ() * MatrixXd::Identity(all, group.count);
      values = qr.matrixQR().topRows(group.count).triangularView<Eigen::Upper>();
    }
    result.values(Eigen::seqN(group.first, group.count), group.columns) = values;
    for (const Index j : group.columns) result.known(g, j) = 1;
  }
  result.energy = (result.values.cwiseAbs2() * result.weights).sum();
  result.count = result.known_in_column().dot(result.weights);
  return result;
}

/// Mean of what is known of each row, where a value is missing.
MatrixXd filled_with_means(const Compact& data) {
  const MatrixXd known = data.known_rows();
  const VectorXd count = (known * data.weights).cwiseMax(std::numeric_limits<double>::min());
  const VectorXd mean = (data.values * data.weights).cwiseQuotient(count);
  return data.values + mean.asDiagonal() * (MatrixXd::Ones(known.rows(), known.cols()) - known);
}

/// For each group of rows, W^T W: k^2 x groups, flattened.
MatrixXd group_grams(const Compact& data, const MatrixXd& rows) {
  const Index k = rows.cols();
  MatrixXd grams(k * k, static_cast<Index>(data.groups.size()));
  for (Index g = 0; g < grams.cols(); ++g) {
    const RowGroup& group = data.groups[static_cast<std::size_t>(g)];
    const auto part = rows.middleRows(group.first, group.count);
    Eigen::Map<MatrixXd>(grams.col(g).data(), k, k) = part.transpose() * part;
  }
  return grams;
}

/// By plain logarithms: gcc 12 takes Eigen's for several values at a time to read what is not initialised.
double log_determinant(const Eigen::LLT<MatrixXd>& llt) {
  double sum = 0;
  for (Index i = 0; i < llt.rows(); ++i) sum += std::log(llt.matrixLLT()(i, i));
  return 2 * sum;
}

/// What the known values of each column say about its coefficients x, whose prior is a normal distribution.
struct Posterior {
  MatrixXd mean;           ///< k x n
  MatrixXd moments;        ///< k^2 x n: E[x x^T] of each column, flattened
  double surprise2 = 0;    ///< twice -log likelihood of the known values, weighted sum
  double unexplained = 0;  ///< expected squared residual, weighted sum
};

/// `grams`: k^2 x n, B_known^T B_known of each column; `right`: k x n, B_known^T c. `precision`: of the prior.
Posterior posterior(const Compact& data, const MatrixXd& grams, const MatrixXd& right, const MatrixXd& precision,
                    double noise) {
  const Index k = right.rows(), n = right.cols();
  Posterior result{.mean = MatrixXd(k, n), .moments = MatrixXd(k * k, n)};
  const VectorXd known = data.known_in_column();
  const double prior_log_det = log_determinant(Eigen::LLT<MatrixXd>(precision));
  for (Index j = 0; j < n; ++j) {
    const Eigen::Map<const MatrixXd> gram(grams.col(j).data(), k, k);
    const Eigen::LLT<MatrixXd> llt(gram + noise * precision);
    const VectorXd x = llt.solve(right.col(j));
    const MatrixXd moment = x * x.transpose() + noise * llt.solve(MatrixXd::Identity(k, k));
    const double energy = data.values.col(j).squaredNorm(), explained = x.dot(right.col(j));
    const double log_det = log_determinant(llt) - prior_log_det - static_cast<double>(k) * std::log(noise);
    result.surprise2 += data.weights[j] * (known[j] * std::log(2 * std::numbers::pi * noise) + log_det +
                                           std::max(energy - explained, 0.0) / noise);
    result.unexplained += data.weights[j] * (energy - 2 * explained + gram.cwiseProduct(moment).sum());
    result.mean.col(j) = x;
    Eigen::Map<MatrixXd>(result.moments.col(j).data(), k, k) = moment;
  }
  return result;
}

/// Rounding and data without noise leave it positive.
double at_least_rounding(double noise, const Compact& data) {
  return std::max(noise, 1e-14 * data.energy / data.count);
}

/// Probabilistic PCA by expectation maximisation.
struct Model {
  MatrixXd directions;  ///< W, compact rows x k
  double noise = 0;     ///< variance of a value

  Posterior expect(const Compact& data) const {
    const Index k = directions.cols();
    return posterior(data, group_grams(data, directions) * data.known, directions.transpose() * data.values,
                     MatrixXd::Identity(k, k), noise);
  }

  /// The directions, and the noise where it is not given, that are most probable given the posterior.
  void maximise(const Compact& data, const Posterior& posterior, double given_noise) {
    const Index k = directions.cols();
    const auto weighted = data.weights.asDiagonal();
    const MatrixXd normal = (posterior.moments * weighted) * data.known.transpose();  // k^2 x groups
    const MatrixXd right = (posterior.mean * weighted) * data.values.transpose();     // k x rows
    for (Index g = 0; g < normal.cols(); ++g) {
      const RowGroup& group = data.groups[static_cast<std::size_t>(g)];
      const Eigen::LDLT<MatrixXd> ldlt(Eigen::Map<const MatrixXd>(normal.col(g).data(), k, k));
      directions.middleRows(group.first, group.count) =
          ldlt.solve(right.middleCols(group.first, group.count)).transpose();
    }
    if (given_noise > 0) return;
    const double explained = directions.cwiseProduct(right.transpose()).sum();
    noise = at_least_rounding((data.energy - explained) / data.count, data);
  }
};

/// A factorization of the compact rows, and the noise that it leaves.
struct Fit {
  BatchPca pca;
  double noise = 0;
};

Fit fit(const Compact& data, int rank, const MissingPcaOptions& options) {
  const std::span<const double> weights(data.weights.data(), static_cast<std::size_t>(data.weights.size()));
  Fit result{batch_pca_in_double(filled_with_means(data), rank, weights)};
  if (!(data.energy > 0)) return result;
  const BatchPca& start = result.pca;
  const MatrixXd known = data.known_rows();
  const auto missed = [&](const BatchPca& pca) {
    const MatrixXd miss = known.cwiseProduct(data.values - pca.basis * pca.coefficients);
    return (miss.cwiseAbs2() * data.weights).sum();
  };
  // Directions carry the standard deviation of their coefficients: the scores are standard normal.
  const VectorXd deviation = ((start.coefficients.cwiseAbs2() * data.weights) / data.weights.sum()).cwiseSqrt();
  Model model{start.basis * deviation.asDiagonal(),
              at_least_rounding(options.noise > 0 ? options.noise : missed(start) / data.count, data)};
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < options.max_iterations; ++i) {
    const Posterior posterior = model.expect(data);
    const double now = 0.5 * posterior.surprise2 / data.count;
    if (before - now <= options.convergence) break;
    before = now;
    model.maximise(data, posterior, options.noise);
  }
  // In singular order, where the product W x counts and not how it is split.
  result.pca = batch_pca_in_double(model.directions * model.expect(data).mean, rank, weights);
  result.pca.relative_error = std::sqrt(missed(result.pca) / data.energy);
  result.noise = model.noise;
  return result;
}

}  // namespace

BatchPca batch_pca_missing(const Eigen::MatrixXf& columns, const KnownValues& known, int rank,
                           std::span<const double> weights, const MissingPcaOptions& options) {
  const Compact data = compact(columns, known, weights);
  BatchPca pca = fit(data, rank, options).pca;
  pca.basis = data.expand(pca.basis, columns.rows());
  return pca;
}

BatchPca batch_pca_imputed(const Eigen::MatrixXf& columns, const KnownValues& known, int rank, int imputing_rank,
                           std::span<const double> weights, const MissingPcaOptions& options) {
  const Compact data = compact(columns, known, weights);
  const std::span<const double> of_columns(data.weights.data(), static_cast<std::size_t>(data.weights.size()));
  if ((data.known.array() != 0).all()) {
    BatchPca pca = batch_pca_in_double(data.values, rank, of_columns);
    pca.basis = data.expand(pca.basis, columns.rows());
    return pca;
  }
  const Fit imputed = fit(data, std::max(rank, imputing_rank), options);
  const MatrixXd is_known = data.known_rows();
  const MatrixXd completed =
      is_known.cwiseProduct(data.values) + (MatrixXd::Ones(is_known.rows(), is_known.cols()) - is_known)
                                               .cwiseProduct(imputed.pca.basis * imputed.pca.coefficients);
  BatchPca pca = batch_pca_in_double(completed, rank, of_columns);
  const Index k = pca.rank();
  if (k > 0) {
    // The terms that are left out are noise to those that are kept.
    const double shown2 = (pca.coefficients.cwiseAbs2() * data.weights).sum(),
                 left_out = std::max(0.0, pca.singular_values.squaredNorm() - shown2) /
                            (data.weights.sum() * static_cast<double>(columns.rows()));
    const MatrixXd prior =
        pca.coefficients * data.weights.asDiagonal() * pca.coefficients.transpose() / data.weights.sum();
    const MatrixXd precision = prior_precision(prior, imputed.noise + left_out);
    const MatrixXd grams = group_grams(data, pca.basis) * data.known;
    const MatrixXd projections = pca.basis.transpose() * data.values;
    for (Index j = 0; j < columns.cols(); ++j)
      if ((data.known.col(j).array() == 0).any())
        pca.coefficients.col(j) =
            most_probable_coefficients(grams.col(j).reshaped(k, k), projections.col(j), precision);
    const MatrixXd miss = is_known.cwiseProduct(data.values - pca.basis * pca.coefficients);
    pca.relative_error = std::sqrt((miss.cwiseAbs2() * data.weights).sum() / data.energy);
  }
  pca.basis = data.expand(pca.basis, columns.rows());
  return pca;
}

double surprise(const Eigen::MatrixXf& columns, const KnownValues& known, const MatrixXd& basis,
                std::span<const double> weights, double given_noise) {
  constexpr int kIterations = 500;
  constexpr double kConverged = 1e-8;  // nats
  const Compact data = compact(columns, known, weights);
  const Index k = basis.cols();
  if (basis.rows() != columns.rows()) throw std::invalid_argument("surprise: the basis has other rows");
  MatrixXd of_groups(k * k, static_cast<Index>(data.groups.size())), right = MatrixXd::Zero(k, columns.cols());
  for (Index g = 0; g < of_groups.cols(); ++g) {
    const RowGroup& group = data.groups[static_cast<std::size_t>(g)];
    const MatrixXd part = basis(group.rows, Eigen::all);
    Eigen::Map<MatrixXd>(of_groups.col(g).data(), k, k) = part.transpose() * part;
    right(Eigen::all, group.columns) += part.transpose() * columns(group.rows, group.columns).cast<double>();
  }
  const MatrixXd grams = of_groups * data.known;
  // What is known, projected as if the rest were zero, is of the right size to begin with.
  MatrixXd covariance = right * data.weights.asDiagonal() * right.transpose() / data.weights.sum();
  covariance.diagonal().array() += 1e-6 * data.energy / (data.weights.sum() * static_cast<double>(k));
  const double outside = data.energy - (right.cwiseAbs2() * data.weights).sum();
  double noise = at_least_rounding(given_noise > 0 ? given_noise : outside / data.count, data),
         least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kIterations; ++i) {
    const Posterior p = posterior(data, grams, right, covariance.llt().solve(MatrixXd::Identity(k, k)), noise);
    const double now = 0.5 * p.surprise2 / data.count;
    if (least - now < kConverged) return std::min(least, now);
    least = now;
    covariance = (p.moments * data.weights).reshaped(k, k) / data.weights.sum();
    if (given_noise <= 0) noise = at_least_rounding(p.unexplained / data.count, data);
  }
  return least;
}

}  // namespace sheen
