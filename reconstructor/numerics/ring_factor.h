// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace sheen {

/// When the online SVD grows, and how far.
struct RingFactorOptions {
  int max_rank = 24;        ///< terms kept after a compression
  int block = 12;           ///< columns appended between compressions
  double tolerance = 0.01;  ///< Frobenius norm of what may be lost, relative to that of all columns: eps
};

/// What adding one column did.
struct ColumnReport {
  double norm = 0;           ///< ||c|| over the rows of the column
  double residual_norm = 0;  ///< ||p||, the part orthogonal to the basis (000 sec. 3.1)
  bool grew = false;         ///< the basis got a new direction
};

/// Online SVD of the columns of one vertex ring (000 sec. 3.1), as a deferred Brand update: between compressions a
/// column costs two passes over the basis and no SVD; every `block` new directions one small eigenproblem restores the
/// singular order and drops what the tolerance allows. See docs/decisions/online_svd.md.
///
///   B  rows x rank   orthonormal basis (float)          C ~ B Y
///   Y  rank x views  coefficients of the kept views     (float)
///   G  rank x rank   sum over all columns of w y y^T    (double): the views that were merged away still count
///
/// Zero columns are kept (y = 0). Columns must be finite; rows that an image does not show are filled by `impute`
/// first.
class RingFactor {
 public:
  RingFactor(int rows, const RingFactorOptions& options) : options_(options), rows_(rows) {}

  int rows() const { return rows_; }
  int rank() const { return rank_; }
  int views() const { return views_; }
  std::int64_t columns_added() const { return columns_added_; }
  auto basis() const { return basis_.leftCols(rank_); }
  auto coefficients() const { return coefficients_.topLeftCorner(rank_, views_); }
  const Eigen::MatrixXd& gram() const { return gram_; }
  double energy() const { return energy_; }     ///< sum of w ||c||^2
  double lost_energy() const { return lost_; }  ///< sum of w ||p||^2 that the basis does not hold
  std::size_t bytes() const;                    ///< of heap memory held
  /// sqrt(lost / energy): the factor's own estimate of its relative error.
  double relative_error() const { return energy_ > 0 ? std::sqrt(lost_ / energy_) : 0; }

  /// Adds a column (`rows` values) as a new view with a weight > 0.
  ColumnReport add(const Eigen::Ref<const Eigen::VectorXf>& column, double weight = 1);

  /// Most probable coefficients of a column of which only some rows are known: minimises
  /// ||c_known - B_known y||^2 / noise + y^T (G / n)^-1 y; `noise` is the variance of a known row. Stays finite however
  /// few rows are known; with all rows and no noise it is the projection.
  Eigen::VectorXf estimate(const Eigen::Ref<const Eigen::VectorXf>& column, std::span<const std::uint8_t> known,
                           double noise) const;

  /// Gives rows that were zero in every column so far the values `rows_of_basis` (count x rank): a surface point seen
  /// for the first time takes a share of what the ring already knows. Restores orthonormality.
  void reveal(std::span<const int> rows, const Eigen::MatrixXf& rows_of_basis);

  /// Replaces two views by their mean, weighted by how many images each stands for; the second one's place is taken by
  /// the last view. The basis, and what the views contributed to it, stay.
  void merge_views(int kept, int removed, double kept_share);

  /// Restores the singular order and drops what the tolerance and the maximal rank demand. Called by `add`.
  void compress();

 private:
  void reserve_rank(int rank);
  void reserve_views(int views);

  RingFactorOptions options_;
  int rows_;
  int rank_ = 0;
  int views_ = 0;
  int appended_ = 0;  ///< directions since the last compression
  std::int64_t columns_added_ = 0;
  double energy_ = 0;
  double lost_ = 0;
  double weight_sum_ = 0;
  Eigen::MatrixXf basis_;         ///< rows x capacity
  Eigen::MatrixXf coefficients_;  ///< capacity x view capacity
  Eigen::MatrixXd gram_;          ///< rank x rank
};

}  // namespace sheen
