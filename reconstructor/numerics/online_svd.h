// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/numerics/folded_views.h"
#include "reconstructor/numerics/missing_rows.h"
#include "reconstructor/numerics/online_svd_options.h"
#include "reconstructor/numerics/pending_columns.h"
#include "reconstructor/numerics/row_resampling.h"
#include "reconstructor/numerics/svd_basis.h"

namespace sheen {

/// What folding one column in did. In the order in which the columns were added.
struct ColumnReport {
  double norm = 0;           ///< ||c|| over its known rows
  double residual_norm = 0;  ///< ||p||, the part that the basis before its block did not explain (000 sec. 3.1)
  int known_rows = 0;
  bool first = false;  ///< there was nothing to predict it from: the residual is no error of prediction
};

/// Online SVD of the columns of one patch (000 sec. 3.1; there, of one vertex ring), a block at a time. A new column is
/// only written to a buffer; when the block is full it is folded: one projection, one Gram matrix of basis and
/// residuals, one small eigenproblem in double, one product that rotates the basis. See docs/decisions/online_svd.md.
///
///   B  rows x rank           orthonormal basis                       C ~ B Y
///   Y  rank x folded views   coefficients of the folded views
///   G  rank x rank           sum over all folded columns of w y y^T (double): views that were merged still count
///
/// It is made of four parts, which change for reasons of their own:
///
///   PendingColumns  the columns of a block until it is folded; which rows each hides, a bit per row
///   SvdBasis        B and G, and the algebra of a fold: equations (1) to (5), with their costs
///   FoldedViews     Y, and what each view weighs and lacks: merging, removing
///   MissingRows     what columns do not show: imputation, rows that are seen late
///
/// The first `displayed_rank()` columns of B span the leading singular subspace and are rotated as little as possible
/// from fold to fold (Procrustes), so displayed coefficients do not jump; the rest, in singular order, are guard
/// terms, which make the result independent of the order of the columns.
///
/// Rows that a column does not show (`known` = 0) are imputed when its block is folded, with the basis before the block
/// (see imputation.h), and again each time that the columns have grown by a tenth: early guesses do not stay. What such
/// a column showed of some rows (`sketch`) is remembered for it, so that the basis may find more in it later. A row
/// that no column showed so far is zero in B; the first columns that show it give it its quantity's mean row, scaled
/// to their values: a surface point seen late is taken to have varied like its patch.
///
/// Where the options name a sensor's noise, basis and pending columns are kept in fixed point of 16 bits between folds,
/// faint terms of 8 (SvdBasis::close), half of the memory: what that adds is far below the noise.
///
/// Views are numbered 0 .. views() - 1, in the order of their arrival: first the folded, then the pending ones. Folds
/// depend on how many columns were added and on nothing else: looking (`settled`, `pending_coefficients`) never changes
/// what comes later. Zero columns are kept (y = 0). Rows that are not finite count as unknown. Any scale from denormals
/// to 1e36 will do.
///
///   OnlineSvd factor(rows, {.max_rank = 12, .tolerance = 0.01}, phase);
///   for (...) reports = factor.add(column, known, weight);   // reports of the block, when this column filled it
///   OnlineSvd now = factor.settled();                       // all columns folded, for a picture or a file
///   now.displayed_basis() * now.displayed_coefficients()     // the best approximation of rank <= max_rank
template <typename Scalar>
class BasicOnlineSvd {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using ConstVectorRef = Eigen::Ref<const Vector>;
  using Reports = std::vector<ColumnReport>;

  /// `phase`: factors of differing phase fold at different columns, which spreads the work evenly over images.
  BasicOnlineSvd(const RowPlanes& rows, const OnlineSvdOptions& options, unsigned phase = 0);

  const OnlineSvdOptions& options() const { return options_; }
  int rows() const { return basis_.rows(); }
  int rank() const { return basis_.rank(); }
  bool seen(int row) const { return missing_.seen(row); }    ///< some folded column showed it
  int displayed_rank() const { return basis_.displayed(); }  ///< terms that the tolerance asks for, at most max_rank
  int views() const { return folded_views() + pending(); }
  int folded_views() const { return views_.count(); }
  int pending() const { return pending_.count(); }
  std::int64_t columns_added() const { return columns_added_; }

  Matrix basis() const { return basis_.leading(rank()); }                ///< as it is kept
  Matrix orthonormal_basis() const { return opened().leading(rank()); }  ///< as a fold finds it (SvdBasis::open)
  const Matrix& coefficients() const { return views_.coefficients(); }   ///< rank x folded_views()
  Matrix displayed_basis() const { return basis_.leading(displayed_rank()); }
  PackedColumns<Scalar> packed_displayed_basis() const { return basis_.packed(displayed_rank()); }  ///< as it is kept
  /// What the basis explains of a row of a folded view.
  Scalar explained(int view, int row) const { return basis_.dot(row, views_.coefficients().col(view)); }
  /// displayed_rank() x folded_views(). A view that hides rows has the coefficients that are most probable given what
  /// it showed and that only these terms will explain it: the terms behind the displayed ones are noise then.
  Matrix displayed_coefficients() const { return missing_.displayed_coefficients(opened(), views_, row_noise()); }
  Eigen::MatrixXd gram() const { return basis_.gram(); }
  /// Squared singular values of the folded columns (each times the root of its weight), descending.
  const Eigen::VectorXd& spectrum() const { return basis_.spectrum(); }
  double energy() const { return basis_.energy(); }     ///< sum of w ||c||^2 over the folded columns
  double lost_energy() const { return basis_.lost(); }  ///< of that, what the basis does not hold
  /// sqrt(lost / energy): the factor's own estimate of its relative error.
  double relative_error() const { return energy() > 0 ? std::sqrt(lost_energy() / energy()) : 0; }
  /// The same for the displayed terms alone.
  double displayed_error() const { return basis_.displayed_error(); }
  /// Variance of a known row that the basis leaves unexplained: a running mean, not less than the sensor's.
  double row_noise() const { return std::max(row_noise_, options_.sensor_variance); }
  std::size_t bytes() const;                                                      ///< of heap memory held
  std::size_t displayed_bytes() const { return basis_.bytes(displayed_rank()); }  ///< of `packed_displayed_basis`
  /// Upper bound of `bytes` for a factor of so many rows that holds so many terms, so many columns in its buffer and so
  /// many views, whatever columns come. Fractions are means over factors. `sketched`: rows of which views that hide
  /// rows remember what they showed (OnlineSvdOptions::witnesses). `packed`: whether the options name a sensor's noise.
  static double bytes_for(double rows, double terms, double columns, double views, double sketched, bool packed);

  /// Adds a column (`rows` values) as a new view with a weight > 0. Not empty when the column filled its block, which
  /// is then folded: a report for each column of the block.
  Reports add(const ConstVectorRef& column, double weight = 1) { return add(column, {}, weight); }
  /// `known`: for each row; 0 where the column does not show it and its value means nothing. Empty: all are known.
  Reports add(const ConstVectorRef& column, std::span<const std::uint8_t> known, double weight = 1);

  /// Folds the pending columns now, and so moves later folds: for benchmarks and for a factor that is complete.
  Reports fold();

  /// Folds the pending columns and lets go of all terms beyond lower limits at once; they hold from now on.
  Reports limit(int max_rank, int internal_rank, int block);

  /// A copy with all columns folded.
  BasicOnlineSvd settled() const;
  /// Of a pending column, as it was added; NaN where it does not show the row.
  Scalar pending_value(int column, int row) const;
  /// Most probable coefficients of the pending columns in the present basis: rank x pending().
  Matrix pending_coefficients() const;

  /// Most probable coefficients of a column of which only some rows are known: minimises
  /// ||c_known - B_known y||^2 / noise + y^T (G / n)^-1 y; `noise` is the variance of a known row. Stays finite however
  /// few rows are known; with all rows known it is the projection.
  Vector estimate(const ConstVectorRef& column, std::span<const std::uint8_t> known, double noise) const;

  /// Other rows in place of those that the factor has; no column may be pending. Coefficients, weights and order of the
  /// views stay, as far as the new rows show them.
  void resample(const RowResampling& by);

  /// Replaces two folded views by their mean, weighted by their weights; views behind `removed` move up by one. The
  /// basis, G and the energy stay.
  void merge_views(int kept, int removed);

  /// Takes a view out again, as if it had not been added: its part of G and of the lost energy goes, the singular order
  /// is restored and rank is given back where the tolerance allows. Views behind it move up by one. Of a view that
  /// others were merged into, all are taken out; how they scattered about their mean is removed in proportion.
  void remove(int view);
  /// Takes one column, as it was added, out of a view that it was merged into.
  void take_from(int view, const ConstVectorRef& column, std::span<const std::uint8_t> known, double weight);

  /// What each view stands for: sum of the weights of its columns.
  double weight_of(int view) const {
    return view < folded_views() ? views_.weight(view) : pending_.weight(view - folded_views());
  }

 private:
  /// The basis as a fold finds it.
  SvdBasis<Scalar> opened() const {
    SvdBasis<Scalar> basis = basis_;
    basis.open();
    return basis;
  }
  int block_size() const;
  ColumnReport report(const Fold& fold, int column, bool first) const;
  void follow_noise(double unexplained);
  void forget_noise_of_the_removed();
  void turn_to_singular_order();
  void close_basis();
  void rediagonalise();

  OnlineSvdOptions options_;
  unsigned phase_;
  int block_due_ = 1;       ///< columns that the block will have
  bool predicted_ = false;  ///< any column, which `row_noise` follows
  std::int64_t columns_added_ = 0, columns_folded_ = 0;
  double row_noise_ = 0;
  SvdBasis<Scalar> basis_;
  FoldedViews<Scalar> views_;
  MissingRows<Scalar> missing_;
  PendingColumns<Scalar> pending_;
};

using OnlineSvd = BasicOnlineSvd<float>;
using OnlineSvdDouble = BasicOnlineSvd<double>;

}  // namespace sheen
