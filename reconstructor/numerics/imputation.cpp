// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/imputation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <utility>
#include <vector>

namespace sheen {
namespace {

using Eigen::MatrixXd;
using row_panels::Columns;

/// Rows that are hidden in the same columns: part of `Patterns::rows`.
struct Group {
  std::uint64_t hidden;
  std::span<const int> rows;
};

struct Patterns {
  std::vector<int> rows;
  std::vector<Group> groups;
};

/// Groups of rows of equal pattern, by ascending pattern.
Patterns group_rows(std::span<const std::uint64_t> hidden) {
  // A sample's channels, and mostly its neighbours, are hidden together: runs are sorted and not rows.
  std::vector<std::pair<std::uint64_t, int>> runs;
  for (std::size_t row = 0; row < hidden.size(); ++row)
    if (row == 0 || hidden[row] != hidden[row - 1]) runs.emplace_back(hidden[row], static_cast<int>(row));
  std::sort(runs.begin(), runs.end());
  Patterns patterns;
  patterns.rows.reserve(hidden.size());
  for (std::size_t first = 0; first < runs.size();) {
    const std::size_t begin = patterns.rows.size();
    const std::uint64_t pattern = runs[first].first;
    for (; first < runs.size() && runs[first].first == pattern; ++first)
      for (auto row = static_cast<std::size_t>(runs[first].second); row < hidden.size() && hidden[row] == pattern;
           ++row)
        patterns.rows.push_back(static_cast<int>(row));
    patterns.groups.push_back({pattern, std::span(patterns.rows.data() + begin, patterns.rows.size() - begin)});
  }
  return patterns;
}

/// Gram matrix of some rows of the basis.
template <typename Scalar>
MatrixXd gram_of_rows(const Columns<const Scalar>& basis, std::span<const int> rows) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const auto count = static_cast<Eigen::Index>(rows.size());
  constexpr Eigen::Index kFew = 16;  // rows that are not worth a panel
  if (count < kFew) {
    MatrixXd picked(basis.count, count);
    for (Eigen::Index i = 0; i < count; ++i)
      for (int k = 0; k < basis.count; ++k) picked(k, i) = basis.column(k)[rows[i]];
    return picked.lazyProduct(picked.transpose());
  }
  Matrix picked = Matrix::Zero(row_panels::padded(count), basis.count);
  for (int k = 0; k < basis.count; ++k) {
    const Scalar* column = basis.column(k);
    for (Eigen::Index i = 0; i < count; ++i) picked(i, k) = column[rows[i]];
  }
  const Columns<const Scalar> view{picked.data(), picked.rows(), basis.count};
  return row_panels::inner_products(view, view, picked.rows(), true);
}

}  // namespace

template <typename Scalar>
MatrixXd known_grams(const Columns<const Scalar>& basis, std::span<const std::uint64_t> hidden, int columns) {
  const Patterns patterns = group_rows(hidden);
  std::vector<std::size_t> hidden_rows(columns, 0);
  for (const Group& group : patterns.groups)
    for (std::uint64_t bits = group.hidden; bits != 0; bits &= bits - 1)
      hidden_rows[std::countr_zero(bits)] += group.rows.size();
  std::uint64_t mostly_hidden = 0;
  const Eigen::Index rank = basis.count;
  MatrixXd known(rank * rank, columns);
  for (int j = 0; j < columns; ++j) {
    const bool mostly = 2 * hidden_rows[j] > hidden.size();
    if (mostly) mostly_hidden |= std::uint64_t{1} << j;
    Eigen::Map<MatrixXd> gram(known.col(j).data(), rank, rank);
    gram.setZero();
    if (!mostly) gram.setIdentity();
  }

  constexpr int kAtOnce = 64;  // groups whose Gram matrices stay in the cache
  MatrixXd grams(rank * rank, kAtOnce), counts(kAtOnce, columns);
  int waiting = 0;
  const auto flush = [&] {
    known.noalias() += grams.leftCols(waiting) * counts.topRows(waiting);
    waiting = 0;
  };
  const std::uint64_t all = columns == kPatternColumns ? ~std::uint64_t{0} : (std::uint64_t{1} << columns) - 1;
  for (const Group& group : patterns.groups) {
    const std::uint64_t plus = ~group.hidden & mostly_hidden & all, minus = group.hidden & ~mostly_hidden & all;
    if ((plus | minus) == 0) continue;
    Eigen::Map<MatrixXd>(grams.col(waiting).data(), rank, rank) = gram_of_rows(basis, group.rows);
    for (int j = 0; j < columns; ++j)
      counts(waiting, j) = static_cast<double>(plus >> j & 1) - static_cast<double>(minus >> j & 1);
    if (++waiting == kAtOnce) flush();
  }
  flush();
  return known;
}

MatrixXd prior_precision(const MatrixXd& prior, double noise) {
  // Floors: directions that have hardly been used stay invertible, and a few known rows without noise stay finite.
  constexpr double kLeastShare = 1e-6, kLeastNoise = 1e-12;
  const Eigen::Index rank = prior.rows();
  MatrixXd covariance = prior;
  covariance.diagonal().array() += std::max(kLeastShare * prior.diagonal().mean(), 1e-300);
  return std::max(noise, kLeastNoise * prior.trace()) * covariance.llt().solve(MatrixXd::Identity(rank, rank));
}

Eigen::VectorXd most_probable_coefficients(const Eigen::Ref<const MatrixXd>& known,
                                           const Eigen::Ref<const Eigen::VectorXd>& projection,
                                           const MatrixXd& precision) {
  MatrixXd normal = known + precision;
  normal.diagonal().array() += std::max(1e-9 * normal.diagonal().mean(), 1e-300);
  const Eigen::VectorXd y = normal.ldlt().solve(projection);
  if (y.allFinite()) return y;
  return Eigen::VectorXd::Zero(projection.size());
}

template MatrixXd known_grams<float>(const Columns<const float>&, std::span<const std::uint64_t>, int);
template MatrixXd known_grams<double>(const Columns<const double>&, std::span<const std::uint64_t>, int);

}  // namespace sheen
