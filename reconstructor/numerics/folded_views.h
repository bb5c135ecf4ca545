// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "reconstructor/numerics/shown_rows.h"
#include "reconstructor/numerics/svd_basis.h"

namespace sheen {

/// The ledger of the views that were folded into an online SVD: what each of them is in the basis, what it
/// weighs, and what the basis does not hold of it. It follows the basis as that rotates, and it can say what G is
/// (`SvdBasis`) when views were taken out: merged views become their weighted mean, and how they scattered about it is
/// summed up in one matrix, so that always
///
///   G = Y diag(w) Y^T + S        Y  rank x count    S  rank x rank, empty before the first merger
template <typename Scalar>
class FoldedViews {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Shown = ShownRows;

  int count() const { return static_cast<int>(views_.size()); }
  const Matrix& coefficients() const { return coefficients_; }   ///< Y
  double weight(int view) const { return views_[view].weight; }  ///< sum over its columns
  double total_weight() const;
  double lost(int view) const { return views_[view].lost; }  ///< ||c||^2 - ||y||^2, mean over its columns
  /// Of a row that it showed: variance of what the basis left unexplained when it was folded, mean over its columns;
  /// negative where there was nothing to explain it by.
  double unexplained(int view) const { return views_[view].unexplained; }
  const Shown* shown(int view) const { return views_[view].shown.get(); }  ///< null when all rows are known
  bool any_hides_rows() const;
  Eigen::MatrixXd gram() const;
  /// Weighted sum of the coefficients.
  Eigen::VectorXd weighted_sum() const;
  std::size_t bytes() const;

  /// A column that was folded.
  struct Arrival {
    double weight;
    int exponent;  ///< the fold was given the column times 2^-exponent
    std::shared_ptr<const Shown> shown;
    double unexplained = -1;  ///< `FoldedViews::unexplained`
  };
  /// Makes each column of a fold a view. The rotation of that fold has been followed.
  void append(const Fold& fold, std::vector<Arrival> columns);

  /// The basis has rotated.
  void follow(const BasisRotation& rotation);
  /// Y <- factor Y.
  void multiply(const Eigen::MatrixXd& factor);
  /// The rows are others, `share` times as many: what was lost is as much for each of them.
  void rows_replaced(double share);
  void set_shown(int view, std::shared_ptr<const Shown> shown) { views_[view].shown = std::move(shown); }

  /// Replaces two views by their weighted mean; `shown` is what the mean shows.
  void merge(int kept, int removed, std::shared_ptr<const Shown> shown);
  /// Takes a view out. Of one that others were merged into, all are; how they scattered goes in proportion.
  void remove(int view);
  /// Takes a column of coefficients y out of a view that weighs more; `shown` is what is left of what it showed.
  void take_from(int view, const Eigen::VectorXd& y, double weight, std::shared_ptr<const Shown> shown);
  /// The coefficients are known better: the basis holds so much less of it.
  void improve(int view, const Eigen::VectorXd& y, double lost);

 private:
  void erase(int view);

  struct View {
    double weight;
    double lost;
    double scatter;  ///< trace of its part of S
    double unexplained;
    std::shared_ptr<const Shown> shown;
  };

  Matrix coefficients_;
  Eigen::MatrixXd scatter_;
  std::vector<View> views_;
};

}  // namespace sheen
