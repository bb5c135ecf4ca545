// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sheen {

/// What stands for the rows that a column does not show.
enum class Imputation {
  kMostProbable,  ///< with a prior, and again as the basis learns (docs/decisions/missing_samples.md)
  kLeastSquares,  ///< the paper's (000 sec. 3.2), for comparison: once, when the column is folded
};

/// When the online SVD grows, and how far.
struct RingFactorOptions {
  int max_rank = 24;           ///< terms displayed, >= 1
  int internal_rank = 0;       ///< terms kept, >= max_rank; 0 = 2 * max_rank, at least max_rank + 8, at most 32 (Brand)
  int block = 12;              ///< columns buffered between folds, 1..32; fewer while there are few
  double tolerance = 0.01;     ///< Frobenius norm of what may be lost, relative to that of all columns: eps
  int channels = 1;            ///< rows i, i + channels, ... hold the same quantity at different places
  double sensor_variance = 0;  ///< of a known row, in squared units of the columns: imputation never trusts one more
  Imputation imputation = Imputation::kMostProbable;
  double residual_memory = 0.8;  ///< of the running mean of what the basis leaves unexplained a row (`row_noise`)

  int terms_kept() const;
  /// Of the rows of a factor: those of which every view that hides rows remembers what it showed.
  int witnesses(int rows) const;
  /// These, with at most so many terms and columns a block.
  RingFactorOptions limited_to(int most_displayed, int most_kept, int most_in_block) const;
};

/// What folding one column in did. In the order in which the columns were added.
struct ColumnReport {
  double norm = 0;           ///< ||c|| over its known rows
  double residual_norm = 0;  ///< ||p||, the part that the basis before its block did not explain (000 sec. 3.1)
  int known_rows = 0;
  bool first = false;  ///< there was nothing to predict it from: the residual is no error of prediction
};

/// Online SVD of the columns of one vertex ring (000 sec. 3.1), a block at a time. A new column is only written to a
/// buffer; when the block is full it is folded: one projection, one Gram matrix of basis and residuals, one small
/// eigenproblem in double, one product that rotates the basis. See docs/decisions/online_svd.md.
///
///   B  rows x rank           orthonormal basis                       C ~ B Y
///   Y  rank x folded views   coefficients of the folded views
///   G  rank x rank           sum over all folded columns of w y y^T (double): views that were merged still count
///
/// The first `displayed_rank()` columns of B span the leading singular subspace and are turned as little as possible
/// from fold to fold (Procrustes), so displayed coefficients do not jump; the rest, in singular order, is the appendix
/// that makes the result independent of the order of the columns.
///
/// Rows that a column does not show (`known` = 0) are imputed when its block is folded, with the basis before the block
/// (see imputation.h), and again each time that the columns have grown by a tenth: early guesses do not stay. What such
/// a column showed of some rows (`sketch`) is remembered for it, so that the basis may find more in it later. A row
/// that no column showed so far is zero in B; the first columns that show it give it its channel's mean row, scaled to
/// their values: a surface point seen late is taken to have varied like its ring.
///
/// Views are numbered 0 .. views() - 1, in the order of their arrival: first the folded, then the pending ones. Folds
/// depend on how many columns were added and on nothing else: looking (`settled`, `pending_coefficients`) never changes
/// what comes later. Zero columns are kept (y = 0). Rows that are not finite count as unknown. Any scale from denormals
/// to 1e36 will do.
///
///   RingFactor factor(rows, {.max_rank = 12, .tolerance = 0.01}, phase);
///   for (...) reports = factor.add(column, known, weight);   // reports of the block, when this column filled it
///   RingFactor now = factor.settled();                       // all columns folded, for a picture or a file
///   now.displayed_basis() * now.displayed_coefficients()     // the best approximation of rank <= max_rank
template <typename Scalar>
class BasicRingFactor {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using ConstVectorRef = Eigen::Ref<const Vector>;
  using Reports = std::vector<ColumnReport>;

  /// `phase`: factors of differing phase fold at different columns, which spreads the work evenly over images.
  BasicRingFactor(int rows, const RingFactorOptions& options, unsigned phase = 0);

  const RingFactorOptions& options() const { return options_; }
  int rows() const { return rows_; }
  int rank() const { return rank_; }
  int displayed_rank() const { return displayed_; }  ///< terms that the tolerance asks for, at most max_rank
  int views() const { return folded_views() + pending(); }
  int folded_views() const { return static_cast<int>(coefficients_.cols()); }
  int pending() const { return static_cast<int>(pending_.size()); }
  std::int64_t columns_added() const { return columns_added_; }

  auto basis() const { return basis_.topLeftCorner(rows_, rank_); }
  const Matrix& coefficients() const { return coefficients_; }  ///< rank x folded_views()
  auto displayed_basis() const { return basis_.topLeftCorner(rows_, displayed_rank()); }
  /// displayed_rank() x folded_views(). A view that hides rows has the coefficients that are most probable given what
  /// it showed and that only these terms will explain it: the terms behind the displayed ones are noise then.
  Matrix displayed_coefficients() const;
  const Eigen::MatrixXd& gram() const { return gram_; }
  /// Squared singular values of the folded columns (each times the root of its weight), descending.
  const Eigen::VectorXd& spectrum() const { return spectrum_; }
  double energy() const { return gram_.trace() + lost_; }  ///< sum of w ||c||^2 over the folded columns
  double lost_energy() const { return lost_; }             ///< of that, what the basis does not hold
  /// sqrt(lost / energy): the factor's own estimate of its relative error.
  double relative_error() const { return energy() > 0 ? std::sqrt(lost_ / energy()) : 0; }
  /// The same for the displayed terms alone.
  double displayed_error() const;
  /// Variance of a known row that the basis leaves unexplained: a running mean, not less than the sensor's.
  double row_noise() const { return std::max(row_noise_, options_.sensor_variance); }
  std::size_t bytes() const;  ///< of heap memory held

  /// Adds a column (`rows` values) as a new view with a weight > 0. Not empty when the column filled its block, which
  /// is then folded: a report a column of the block.
  Reports add(const ConstVectorRef& column, double weight = 1) { return add(column, {}, weight); }
  /// `known`: a row; 0 where the column does not show it and its value means nothing. Empty: all are known.
  Reports add(const ConstVectorRef& column, std::span<const std::uint8_t> known, double weight = 1);

  /// Folds the pending columns now, and so moves later folds: for benchmarks and for a factor that is complete.
  Reports fold();

  /// Folds the pending columns and lets go of all terms beyond lower limits at once; they hold from now on.
  Reports limit(int max_rank, int internal_rank, int block);

  /// A copy with all columns folded.
  BasicRingFactor settled() const;
  /// Of a pending column, as it was added; NaN where it does not show the row.
  Scalar pending_value(int column, int row) const;
  /// Most probable coefficients of the pending columns in the present basis: rank x pending().
  Matrix pending_coefficients() const;

  /// Most probable coefficients of a column of which only some rows are known: minimises
  /// ||c_known - B_known y||^2 / noise + y^T (G / n)^-1 y; `noise` is the variance of a known row. Stays finite however
  /// few rows are known; with all rows known it is the projection.
  Vector estimate(const ConstVectorRef& column, std::span<const std::uint8_t> known, double noise) const;

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
    return view < folded_views() ? views_[view].weight : pending_[view - folded_views()].weight;
  }

 private:
  /// What a view that hides rows showed.
  struct Shown {
    std::vector<std::uint64_t> hidden;  ///< a bit a row; one of its columns hides it
    std::vector<Scalar> sketch;         ///< values of the witness rows that it showed, in their order
  };
  struct Pending {
    double weight;
    int exponent;                       ///< the buffered column is the given one times 2^-exponent
    std::vector<std::uint64_t> hidden;  ///< a bit a row; empty when all rows are known
    bool guessed = false;               ///< it showed no row that was seen before: the mean of the views predicts it
    int known_rows(int rows) const;
  };
  struct View {
    double weight;                       ///< sum over its columns
    double lost;                         ///< ||c||^2 - ||y||^2, weighted mean over its columns
    double scatter;                      ///< trace of its part of `scatter_`
    std::shared_ptr<const Shown> shown;  ///< null when all rows are known
  };
  struct Block;  // one fold, in ring_fold.cpp
  struct Turn;

  int block_size() const;
  static bool bit(const std::vector<std::uint64_t>& bits, int row) { return bits[row / 64] >> (row % 64) & 1; }
  bool seen(int row) const { return bit(seen_, row); }
  Eigen::MatrixXd prior() const;  ///< covariance of a column's coefficients: G / n
  std::vector<std::uint64_t> hidden_patterns() const;
  Eigen::MatrixXd pending_projections(std::span<const std::uint64_t> hidden) const;
  Eigen::MatrixXd foreseen(std::span<const std::uint64_t> hidden, const Eigen::MatrixXd& level);
  void reveal_rows(std::span<const double> weight, std::span<const std::uint64_t> hidden);
  template <typename Visit>
  void visit_witnesses(Visit visit) const;
  std::shared_ptr<const Shown> shown_by(int column) const;
  std::shared_ptr<const Shown> shown_by_both(int kept, int removed, Scalar share) const;
  std::shared_ptr<const Shown> without(const View& view, const ConstVectorRef& column, Scalar share) const;
  Matrix missed_projections(std::span<const int> views) const;
  template <typename Visit>
  void visit_masked_views(Visit visit) const;
  void impute_again_when_due();
  void impute_again();
  void restore_orthonormality();
  Reports split_residuals(Block& block);
  ColumnReport report(const Pending& column, double norm2, double residual2);
  Eigen::VectorXd orthonormalise_again(Block& block);
  void choose_rank(const Eigen::VectorXd& descending, double lost, Turn& turn) const;
  Turn singular_turn(const Block& block) const;
  double growth(const Block& block, const Eigen::VectorXd& norm2, const Turn& turn) const;
  void absorb(Block& block);
  void apply(Turn& turn, const Block& block);
  void forget_directions(const Turn& turn, const Block& block);
  void append_views(const Block& block, const Eigen::MatrixXd& coordinates);
  void turn_to_singular_order();
  void rediagonalise();
  void erase_view(int view);

  RingFactorOptions options_;
  int rows_;
  unsigned phase_;
  int witnesses_;  ///< rows that sketches remember
  int rank_ = 0, displayed_ = 0;
  int unseen_rows_;
  std::int64_t turns_ = 0;  ///< of the basis
  std::int64_t columns_added_ = 0, columns_folded_ = 0, columns_predicted_ = 0;
  std::int64_t imputed_at_ = 0;  ///< columns folded when hidden rows were last imputed again
  double lost_ = 0;
  double row_noise_ = 0;
  Matrix basis_;                     ///< padded rows x rank
  Matrix coefficients_;              ///< rank x folded views
  std::vector<View> views_;          ///< the folded ones
  Eigen::MatrixXd gram_;             ///< rank x rank
  Eigen::MatrixXd scatter_;          ///< rank x rank: G - Y diag(w) Y^T, what merging took from Y; empty before
  Eigen::VectorXd spectrum_;         ///< rank
  std::vector<std::uint64_t> seen_;  ///< a bit a row: some folded column showed it
  Matrix buffer_;                    ///< padded rows x block: the pending columns, 0 where hidden
  std::vector<Pending> pending_;
};

using RingFactor = BasicRingFactor<float>;
using RingFactorDouble = BasicRingFactor<double>;

}  // namespace sheen
