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

/// Gram matrices of some rows of the basis.
template <typename Scalar>
class RowGrams {
 public:
  explicit RowGrams(const Columns<const Scalar>& basis)
      : basis_(basis), stride_(row_panels::padded(basis.count)), picked_(kPicked * stride_, Scalar(0)) {}

  /// Upper triangle, column by column: rank (rank + 1) / 2 values.
  void gram(std::span<const int> rows, double* packed) {
    std::fill_n(packed, basis_.count * (basis_.count + 1) / 2, 0.0);
    for (; !rows.empty(); rows = rows.subspan(std::min(rows.size(), kPicked))) {
      const std::size_t count = std::min(rows.size(), kPicked);
      for (int k = 0; k < basis_.count; ++k)
        for (std::size_t i = 0; i < count; ++i) picked_[i * stride_ + k] = basis_.column(k)[rows[i]];
      for (int i = 0; i < basis_.count; i += kLanes)
        for (int j = i - i % kTile; j < basis_.count; j += kTile) add_tile(count, i, j, packed);  // within the stride
    }
  }

 private:
  static constexpr int kLanes = row_panels::VectorOf<Scalar>::kLanes;
  static constexpr int kTile = 8;              // columns
  static constexpr std::size_t kPicked = 256;  // rows that are summed up in scalars; their sums in double
  static_assert(row_panels::kPadding % kLanes == 0 && row_panels::kPadding % kTile == 0);

  void add_tile(std::size_t count, int i, int j, double* packed) const {
    row_panels::Vector<Scalar> sum[kTile] = {};
    for (const Scalar* row = picked_.data(); row < picked_.data() + count * stride_; row += stride_) {
      const auto left = row_panels::load(row + i);
      for (int t = 0; t < kTile; ++t) sum[t] += left * row[j + t];
    }
    for (int t = 0; t < kTile && j + t < basis_.count; ++t) {
      Scalar lane[kLanes];
      row_panels::store(lane, sum[t]);
      double* column = packed + (j + t) * (j + t + 1) / 2;
      for (int l = 0; l < kLanes && i + l <= j + t; ++l) column[i + l] += lane[l];
    }
  }

  Columns<const Scalar> basis_;
  std::size_t stride_;
  std::vector<Scalar> picked_;  ///< rows, one behind the other, padded with zeros to whole vectors
};

}  // namespace

template <typename Scalar>
MatrixXd known_grams(const Columns<const Scalar>& basis, std::span<const std::uint64_t> hidden, int columns) {
  const Patterns patterns = group_rows(hidden);
  std::vector<std::size_t> hidden_rows(columns, 0);
  for (const Group& group : patterns.groups)
    for (std::uint64_t bits = group.hidden; bits != 0; bits &= bits - 1)
      hidden_rows[std::countr_zero(bits)] += group.rows.size();
  std::uint64_t mostly_hidden = 0;
  for (int j = 0; j < columns; ++j)
    if (2 * hidden_rows[j] > hidden.size()) mostly_hidden |= std::uint64_t{1} << j;

  constexpr int kAtOnce = 64;  // groups whose Gram matrices stay in the cache
  const Eigen::Index rank = basis.count, triangle = rank * (rank + 1) / 2;
  RowGrams<Scalar> rows(basis);
  MatrixXd sums = MatrixXd::Zero(triangle, columns);  // upper triangles
  MatrixXd grams(triangle, kAtOnce), counts(kAtOnce, columns);
  int waiting = 0;
  const auto flush = [&] {
    sums.noalias() += grams.leftCols(waiting) * counts.topRows(waiting);
    waiting = 0;
  };
  const std::uint64_t all = columns == kPatternColumns ? ~std::uint64_t{0} : (std::uint64_t{1} << columns) - 1;
  for (const Group& group : patterns.groups) {
    const std::uint64_t plus = ~group.hidden & mostly_hidden & all, minus = group.hidden & ~mostly_hidden & all;
    if ((plus | minus) == 0) continue;
    rows.gram(group.rows, grams.col(waiting).data());
    for (int j = 0; j < columns; ++j)
      counts(waiting, j) = static_cast<double>(plus >> j & 1) - static_cast<double>(minus >> j & 1);
    if (++waiting == kAtOnce) flush();
  }
  flush();

  MatrixXd known(rank * rank, columns);
  for (int j = 0; j < columns; ++j) {
    Eigen::Map<MatrixXd> gram(known.col(j).data(), rank, rank);
    const double identity = mostly_hidden >> j & 1 ? 0 : 1;
    const double* sum = sums.col(j).data();
    for (Eigen::Index k = 0; k < rank; ++k) {
      for (Eigen::Index i = 0; i <= k; ++i) gram(i, k) = gram(k, i) = *sum++;
      gram(k, k) += identity;
    }
  }
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
  // b^2 of the dimmest row that still tells how bright its column is: y = c / b then, from a projection b c.
  constexpr double kDimmest = 1e-6;
  MatrixXd normal = known + precision;
  normal.diagonal().array() += std::max(1e-9 * normal.diagonal().mean(), 1e-300);
  const Eigen::LLT<MatrixXd> cholesky(normal);
  if (cholesky.info() == Eigen::Success)
    if (const Eigen::VectorXd y = cholesky.solve(projection); y.allFinite())
      return std::min(1.0, projection.norm() / (kDimmest * std::max(y.norm(), 1e-300))) * y;
  return Eigen::VectorXd::Zero(projection.size());
}

template MatrixXd known_grams<float>(const Columns<const float>&, std::span<const std::uint64_t>, int);
template MatrixXd known_grams<double>(const Columns<const double>&, std::span<const std::uint64_t>, int);

}  // namespace sheen
