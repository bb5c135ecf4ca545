// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>

#include "reconstructor/numerics/folded_views.h"
#include "reconstructor/numerics/online_svd_options.h"
#include "reconstructor/numerics/pending_columns.h"
#include "reconstructor/numerics/row_bits.h"
#include "reconstructor/numerics/row_resampling.h"
#include "reconstructor/numerics/shown_rows.h"
#include "reconstructor/numerics/svd_basis.h"

namespace sheen {

/// Rows that some folded column showed. Those that none showed are zero in the basis.
class SeenRows {
 public:
  explicit SeenRows(int rows) : bits_(words_of(rows), 0), unseen_(rows) {}

  bool has(int row) const { return has_row(bits_, row); }
  int unseen() const { return unseen_; }
  /// Whether a column that hides these rows shows any that was seen.
  bool any_but(const RowBits& hidden) const;
  void add(int row) {
    set_row(bits_, row);
    --unseen_;
  }
  std::size_t bytes() const { return sizeof(std::uint64_t) * bits_.capacity(); }

 private:
  RowBits bits_;
  int unseen_;
};

/// What columns do not show of a patch (000 sec. 3.2; docs/decisions/missing_samples.md), and what is made of it. The
/// coefficients of a column that shows some rows are the most probable ones given these (imputation.h),
///
///   y = argmin ||c_known - B_known y||^2 / noise + y^T (G / n)^-1 y        n: sum of the weights of all views
///
/// with B and G of the patch's basis and `noise` the variance of a known row. That takes B_known^T B_known of all
/// columns at once (known_grams.h) and B_known^T c_known; with r terms each column costs r^3 for the solution and r^2
/// for each group of rows that are hidden together.
template <typename Scalar>
class MissingRows {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using ConstVectorRef = Eigen::Ref<const Vector>;
  using Basis = SvdBasis<Scalar>;
  using Views = FoldedViews<Scalar>;
  using Pending = PendingColumns<Scalar>;
  using Gathered = row_panels::Columns<Scalar>;
  using Shown = ShownRows;

  MissingRows(const RowPlanes& rows, const OnlineSvdOptions& options);

  /// B^T c of each pending column, hidden rows imputed: rank x columns. `gathered`: these columns; `hidden`: their
  /// patterns.
  Eigen::MatrixXd project(const Basis& basis, const Views& views, const Pending& pending, const Gathered& gathered,
                          const HiddenPatterns& hidden, double noise) const;
  /// The same for one column that is not pending; the projection when all of its rows are known.
  Vector estimate(const Basis& basis, const Views& views, const ConstVectorRef& column,
                  std::span<const std::uint8_t> known, double noise) const;
  /// Coefficients of the folded views in the displayed terms alone. A view that hides rows has those that are most
  /// probable given that only these terms will explain it: the terms behind are noise then.
  Matrix displayed_coefficients(const Basis& basis, const Views& views, double noise) const;

  /// Imputes the hidden rows of the folded views again, from what the basis has learnt since, if the columns have grown
  /// by a tenth since the last time: one step of expectation maximisation. Coefficients, G and the lost energy change.
  void impute_again_when_due(Basis& basis, Views& views, std::int64_t columns_folded, double noise);

  /// Gives rows that the basis has never seen, and that the pending columns show, the mean row of their quantity,
  /// scaled to what these show: a surface point seen late is taken to have varied like its patch. Returns the columns
  /// that showed no row seen before and were taken for the mean of the views, a bit each. `weights`: of the gathered
  /// columns.
  std::uint64_t reveal(Basis& basis, Views& views, const Pending& pending, const Gathered& gathered,
                       const Eigen::VectorXd& weights, const HiddenPatterns& hidden, double noise);

  /// What is remembered of what a pending column shows: null when it shows all rows, and where hidden rows are not
  /// imputed again.
  std::shared_ptr<const Shown> shown_by(const Pending& pending, int column) const;
  /// Of the weighted mean of two folded views.
  std::shared_ptr<const Shown> shown_by_both(const Basis& basis, const Views& views, int a, int b) const;
  /// Of a folded view when a column is taken out of it.
  std::shared_ptr<const Shown> shown_without(const Views& views, int view, const ConstVectorRef& column,
                                             double weight) const;

  /// Basis and views have the new rows, and `basis` is the new one. Of what views that hide rows showed, what the basis
  /// explains of it is remembered.
  void resample(const RowResampling& by, const Basis& basis, Views& views, const OnlineSvdOptions& options);
  /// Sets new rows that lie beside one that no column showed to zero.
  void clear_unseen(const RowResampling& by, Matrix& rows) const;

  bool seen(int row) const { return seen_.has(row); }
  std::size_t bytes() const { return seen_.bytes(); }

 private:
  int quantities() const { return std::max(planes_.count(), witnesses_.channels()); }
  int quantity_of(int row) const { return planes_.count() > 1 ? planes_.of(row) : row % witnesses_.channels(); }
  bool was_seen(const RowResampling& by, int row) const;
  Matrix missed_projections(const Basis& basis, const Views& views, std::span<const int> of) const;
  template <typename Visit>
  void visit_masked_views(const Basis& basis, const Views& views, Visit visit) const;
  void impute_again(Basis& basis, Views& views, double noise) const;
  Eigen::MatrixXd mean_rows(const Basis& basis) const;
  Eigen::MatrixXd foreseen(const Basis& basis, const Views& views, const Pending& pending, const Gathered& gathered,
                           const HiddenPatterns& hidden, const Eigen::MatrixXd& level, double noise,
                           std::uint64_t& guessed) const;

  RowPlanes planes_;
  Imputation imputation_;
  WitnessRows witnesses_;
  SeenRows seen_;
  std::int64_t imputed_at_ = 0;  ///< columns folded when hidden rows were last imputed again
};

}  // namespace sheen
