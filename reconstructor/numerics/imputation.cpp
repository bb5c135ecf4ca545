// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/imputation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

namespace sheen {
namespace {

using row_panels::Columns;

/// Gram matrix of some rows of the basis.
template <typename Scalar>
Eigen::MatrixXd gram_of_rows(const Columns<const Scalar>& basis, std::span<const int> rows) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const auto count = static_cast<Eigen::Index>(rows.size());
  Matrix picked = Matrix::Zero(row_panels::padded(count), basis.count);
  for (int k = 0; k < basis.count; ++k) {
    const Scalar* column = basis.column(k);
    for (Eigen::Index i = 0; i < count; ++i) picked(i, k) = column[rows[i]];
  }
  const Columns<const Scalar> view{picked.data(), picked.rows(), basis.count};
  return row_panels::inner_products(view, view, picked.rows(), true);
}

/// Rows that are hidden in the same columns.
struct RowGroup {
  std::uint32_t hidden;
  std::span<const int> rows;
};

}  // namespace

template <typename Scalar>
Eigen::MatrixXd most_probable_coefficients(const Columns<const Scalar>& basis, std::span<const std::uint32_t> hidden,
                                           const Eigen::MatrixXd& projections, const Eigen::MatrixXd& prior,
                                           double noise) {
  const Eigen::Index rank = basis.count;
  const int columns = static_cast<int>(projections.cols());
  Eigen::MatrixXd result = projections;
  std::uint32_t masked = 0;
  for (const std::uint32_t pattern : hidden) masked |= pattern;
  if (masked == 0 || rank == 0) return result;

  std::vector<int> order(hidden.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return hidden[a] < hidden[b]; });
  std::vector<RowGroup> groups;
  std::vector<std::size_t> hidden_rows(columns, 0);
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    const std::uint32_t pattern = hidden[order[first]];
    while (last < order.size() && hidden[order[last]] == pattern) ++last;
    groups.push_back({pattern, std::span(order).subspan(first, last - first)});
    for (int j = 0; j < columns; ++j)
      if (pattern >> j & 1) hidden_rows[j] += last - first;
  }

  // known(j) = I - (hidden rows), or the sum over known rows: a group counts for each column on its smaller side.
  std::uint32_t mostly_hidden = 0;
  for (int j = 0; j < columns; ++j)
    if (2 * hidden_rows[j] > hidden.size()) mostly_hidden |= 1u << j;
  std::vector<Eigen::MatrixXd> known(columns);
  for (int j = 0; j < columns; ++j) {
    if (!(masked >> j & 1)) continue;
    known[j] = Eigen::MatrixXd::Zero(rank, rank);
    if (!(mostly_hidden >> j & 1)) known[j].setIdentity();
  }
  const auto counts_for = [&](const RowGroup& group, int j) {
    return (masked >> j & 1) && (group.hidden >> j & 1) == (~mostly_hidden >> j & 1);
  };
  const auto account = [&](const Eigen::MatrixXd& gram, int j) {
    if (mostly_hidden >> j & 1)
      known[j] += gram;
    else
      known[j] -= gram;
  };
  constexpr std::size_t kGroupsAColumn = 4;
  if (groups.size() <= kGroupsAColumn * static_cast<std::size_t>(columns)) {
    for (const RowGroup& group : groups) {
      Eigen::MatrixXd gram;
      for (int j = 0; j < columns; ++j) {
        if (!counts_for(group, j)) continue;
        if (gram.size() == 0) gram = gram_of_rows(basis, group.rows);
        account(gram, j);
      }
    }
  } else {  // scattered holes: hardly any row shares its pattern with another
    std::vector<int> rows;
    for (int j = 0; j < columns; ++j) {
      if (!(masked >> j & 1)) continue;
      rows.clear();
      for (const RowGroup& group : groups)
        if (counts_for(group, j)) rows.insert(rows.end(), group.rows.begin(), group.rows.end());
      account(gram_of_rows(basis, std::span<const int>(rows)), j);
    }
  }

  // A floor keeps directions that have hardly been used invertible.
  Eigen::MatrixXd covariance = prior;
  covariance.diagonal().array() += std::max(1e-6 * prior.trace() / static_cast<double>(rank), 1e-300);
  const Eigen::MatrixXd precision =
      std::max(noise, 0.0) * covariance.llt().solve(Eigen::MatrixXd::Identity(rank, rank));
  for (int j = 0; j < columns; ++j) {
    if (!(masked >> j & 1)) continue;
    Eigen::MatrixXd normal = known[j] + precision;
    normal.diagonal().array() += 1e-9 * std::max(normal.trace() / static_cast<double>(rank), 1e-300);
    const Eigen::VectorXd y = normal.ldlt().solve(projections.col(j));
    if (y.allFinite())
      result.col(j) = y;
    else
      result.col(j).setZero();
  }
  return result;
}

template Eigen::MatrixXd most_probable_coefficients<float>(const Columns<const float>&, std::span<const std::uint32_t>,
                                                           const Eigen::MatrixXd&, const Eigen::MatrixXd&, double);
template Eigen::MatrixXd most_probable_coefficients<double>(const Columns<const double>&,
                                                            std::span<const std::uint32_t>, const Eigen::MatrixXd&,
                                                            const Eigen::MatrixXd&, double);

}  // namespace sheen
