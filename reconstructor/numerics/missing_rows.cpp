// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/missing_rows.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "reconstructor/numerics/imputation.h"
#include "reconstructor/numerics/known_grams.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using row_panels::columns;

/// Rows of a patch that was dim where it is now bright say little about each other: a quantity's mean row is scaled
/// only where it predicts at least this fraction of a typical value.
constexpr double kDim = 0.04;

/// A revealed row that outshines all others of the patch together as much as this is an event, and starts at zero.
constexpr double kBrightest = 1e3;

/// Of all rows; showing fewer, a column that shows none but new ones does not tell how bright they are.
constexpr double kFewest = 1.0 / 16;

/// Where what is imputed teaches the basis: rows err together (the channels of a sample, neighbours in a highlight), so
/// this many say what one says.
constexpr double kRowsThatErrTogether = 2;

// Between two imputations of the same hidden rows, the columns grow by this factor: the basis has learnt something, and
// the cost of a column stays bounded.
constexpr double kGrowth = 1.1;
constexpr std::int64_t kFirst = 10;  // columns; with fewer, the basis knows too little to correct itself

/// Covariance of a column's coefficients: G / n.
template <typename Scalar>
MatrixXd prior(const SvdBasis<Scalar>& basis, const FoldedViews<Scalar>& views) {
  return basis.gram() / std::max(views.total_weight(), 1e-300);
}

}  // namespace

bool SeenRows::any_but(const RowBits& hidden) const {
  bool any = hidden.empty();
  for (std::size_t word = 0; word < hidden.size(); ++word) any = any || (bits_[word] & ~hidden[word]) != 0;
  return any;
}

template <typename Scalar>
MissingRows<Scalar>::MissingRows(const RowPlanes& rows, const OnlineSvdOptions& options)
    : planes_(rows),
      imputation_(options.imputation),
      witnesses_(rows.rows(), options.channels, options.witnesses(rows.rows())),
      seen_(rows.rows()) {}

/// B_known^T r of views that hide rows, a column each, where r is what B y misses of the witness rows that they showed.
template <typename Scalar>
typename MissingRows<Scalar>::Matrix MissingRows<Scalar>::missed_projections(const Basis& basis, const Views& views,
                                                                             std::span<const int> of) const {
  const auto count = static_cast<Eigen::Index>(of.size());
  Matrix witness_basis(witnesses_.count(), basis.rank()), y(basis.rank(), count);
  const std::vector<int> rows = witnesses_.rows();
  for (int k = 0; k < basis.rank(); ++k)
    for (int w = 0; w < witnesses_.count(); ++w) witness_basis(w, k) = basis.columns().column(k)[rows[w]];
  for (Eigen::Index j = 0; j < count; ++j) y.col(j) = views.coefficients().col(of[j]);
  Matrix missed = -witness_basis * y;
  std::vector<Scalar> sketch(rows.size());
  for (Eigen::Index j = 0; j < count; ++j) {
    const Shown& shown = *views.shown(of[j]);
    shown.sketch.decode(sketch.data());
    const Scalar* next = sketch.data();
    for (int w = 0; w < witnesses_.count(); ++w)
      missed(w, j) = has_row(shown.hidden, rows[w]) ? 0 : missed(w, j) + *next++;
  }
  return witness_basis.transpose() * missed;
}

/// Calls visit(view, known, projection) for the folded views that hide rows: B_known^T B_known and B_known^T c_known.
/// Of the witness rows of a view its sketch knows c, of others B y has to do.
template <typename Scalar>
template <typename Visit>
void MissingRows<Scalar>::visit_masked_views(const Basis& basis, const Views& views, Visit visit) const {
  const int rank = basis.rank();
  std::vector<int> masked;
  for (int v = 0; v < views.count(); ++v)
    if (views.shown(v)) masked.push_back(v);
  for (std::size_t first = 0; first < masked.size() && rank > 0; first += kPatternColumns) {
    const int count = static_cast<int>(std::min<std::size_t>(kPatternColumns, masked.size() - first));
    HiddenPatterns patterns(basis.rows(), 0);
    for (int j = 0; j < count; ++j) mark_hidden(views.shown(masked[first + j])->hidden, j, patterns);
    const Matrix missed = missed_projections(basis, views, std::span(masked).subspan(first, count));
    const MatrixXd grams = known_grams(basis.columns(), patterns, count);
    for (int j = 0; j < count; ++j) {
      const int v = masked[first + j];
      const Eigen::Map<const MatrixXd> known(grams.col(j).data(), rank, rank);
      const VectorXd projection =
          known * views.coefficients().col(v).template cast<double>() + missed.col(j).template cast<double>();
      visit(v, known, projection);
    }
  }
}

template <typename Scalar>
MatrixXd MissingRows<Scalar>::project(const Basis& basis, const Views& views, const Pending& pending,
                                      const Gathered& gathered, const HiddenPatterns& hidden, double noise) const {
  const int rank = basis.rank();
  MatrixXd y = basis.project(gathered);
  if (hidden.empty() || rank == 0) return y;
  const MatrixXd known = known_grams(basis.columns(), hidden, pending.count());
  const MatrixXd covariance = prior(basis, views), precision = prior_precision(covariance, noise);
  for (int j = 0; j < pending.count(); ++j) {
    if (pending.hidden(j).empty()) continue;
    const auto gram = known.col(j).reshaped(rank, rank);
    y.col(j) = imputation_ == Imputation::kLeastSquares ? least_squares_coefficients(gram, y.col(j), covariance)
                                                        : most_probable_coefficients(gram, y.col(j), precision);
  }
  return y;
}

template <typename Scalar>
typename MissingRows<Scalar>::Vector MissingRows<Scalar>::estimate(const Basis& basis, const Views& views,
                                                                   const ConstVectorRef& column,
                                                                   std::span<const std::uint8_t> known,
                                                                   double noise) const {
  const int rows = basis.rows(), rank = basis.rank();
  Matrix shown = Matrix::Zero(row_panels::padded(rows), 1);
  shown.col(0).head(rows) = column;
  HiddenPatterns hidden(rows, 0);
  bool all_known = true;
  for (int row = 0; row < rows; ++row) {
    if ((known.empty() || known[row]) && std::isfinite(column[row])) continue;
    all_known = false;
    hidden[row] = 1;
    shown(row, 0) = 0;
  }
  const MatrixXd y = basis.project(columns(shown, 1));
  if (all_known || rank == 0) return y.col(0).template cast<Scalar>();
  const MatrixXd gram = known_grams(basis.columns(), hidden, 1);
  return stored<Scalar>(
      most_probable_coefficients(gram.reshaped(rank, rank), y.col(0), prior_precision(prior(basis, views), noise)));
}

template <typename Scalar>
void MissingRows<Scalar>::impute_again_when_due(Basis& basis, Views& views, std::int64_t columns_folded, double noise) {
  const auto before = static_cast<double>(std::max(imputed_at_, kFirst));
  if (static_cast<double>(columns_folded) < kGrowth * before) return;
  imputed_at_ = columns_folded;
  if (basis.rank() > 0) impute_again(basis, views, noise);
}

template <typename Scalar>
void MissingRows<Scalar>::impute_again(Basis& basis, Views& views, double noise) const {
  if (!views.any_hides_rows()) return;
  const MatrixXd precision = prior_precision(prior(basis, views), kRowsThatErrTogether * noise);
  MatrixXd gram = basis.gram();
  visit_masked_views(basis, views, [&](int v, const Eigen::Map<const MatrixXd>& known, const VectorXd& projection) {
    const VectorXd before = views.coefficients().col(v).template cast<double>();
    const VectorXd after = most_probable_coefficients(known, projection, precision);
    const VectorXd change = after - before;
    gram.selfadjointView<Eigen::Lower>().rankUpdate(after, views.weight(v)).rankUpdate(before, -views.weight(v));
    // Of ||c_known - B_known y||^2.
    const double lost = std::max(-views.lost(v), change.dot(known * (after + before) - 2 * projection));
    basis.count_lost(views.weight(v), lost);
    views.improve(v, after, lost);
  });
  basis.set_gram(gram.selfadjointView<Eigen::Lower>());
}

template <typename Scalar>
typename MissingRows<Scalar>::Matrix MissingRows<Scalar>::displayed_coefficients(const Basis& basis, const Views& views,
                                                                                 double noise) const {
  const int displayed = basis.displayed();
  Matrix y = views.coefficients().topRows(displayed);
  if (displayed == 0) return y;  // all is black
  const MatrixXd covariance = prior(basis, views);
  const double guard_variance = covariance.diagonal().tail(basis.rank() - displayed).sum() / basis.rows();
  const MatrixXd precision = prior_precision(covariance.topLeftCorner(displayed, displayed), noise + guard_variance);
  visit_masked_views(basis, views, [&](int v, const Eigen::Map<const MatrixXd>& known, const VectorXd& projection) {
    y.col(v) = stored<Scalar>(
        most_probable_coefficients(known.topLeftCorner(displayed, displayed), projection.head(displayed), precision));
  });
  return y;
}

/// Of each quantity, over the rows that were seen: quantities x rank.
template <typename Scalar>
MatrixXd MissingRows<Scalar>::mean_rows(const Basis& basis) const {
  MatrixXd level = MatrixXd::Zero(quantities(), basis.rank());
  VectorXd count = VectorXd::Zero(quantities());
  for (int row = 0; row < basis.rows(); ++row) {
    if (!seen_.has(row)) continue;
    level.row(quantity_of(row)) += basis.row(row).template cast<double>();
    count[quantity_of(row)] += 1;
  }
  for (int q = 0; q < quantities(); ++q) level.row(q) /= std::max(count[q], 1.0);
  return level;
}

/// What the block's columns look like as far as rows that were seen before tell: rank x columns. A column that shows
/// none of those looks like the mean of the views, where these are alike and their rows are: taken for black, it would
/// be a term of its own, and what lies between it and the views would be dark. `level`: mean row of each quantity.
template <typename Scalar>
MatrixXd MissingRows<Scalar>::foreseen(const Basis& basis, const Views& views, const Pending& pending,
                                       const Gathered& gathered, const HiddenPatterns& hidden, const MatrixXd& level,
                                       double noise, std::uint64_t& guessed) const {
  // Until now a column's unseen rows are hidden rows: those of the basis are 0.
  MatrixXd y = project(basis, views, pending, gathered, hidden, noise);
  const VectorXd mean = views.weighted_sum();
  const double weight = views.total_weight();
  const double mean2 = mean.squaredNorm(),
               level2 = (level * mean).squaredNorm() * (basis.rows() - seen_.unseen()) / level.rows();
  if (hidden.empty() || !(mean2 > 0.5 * weight * basis.gram().trace() && level2 > 0.5 * mean2)) return y;
  for (int j = 0; j < pending.count(); ++j) {
    if (seen_.any_but(pending.hidden(j)) || pending.known_rows(j) < kFewest * basis.rows()) continue;
    y.col(j) = std::ldexp(1 / weight, -pending.exponent(j)) * mean;
    guessed |= std::uint64_t{1} << j;
  }
  return y;
}

template <typename Scalar>
std::uint64_t MissingRows<Scalar>::reveal(Basis& basis, Views& views, const Pending& pending, const Gathered& gathered,
                                          const VectorXd& weights, const HiddenPatterns& hidden, double noise) {
  std::uint64_t guessed = 0;
  if (seen_.unseen() == 0) return guessed;
  std::vector<int> revealed;
  const std::uint64_t all = (std::uint64_t{1} << pending.count()) - 1;
  for (int row = 0; row < basis.rows(); ++row)
    if (!seen_.has(row) && (hidden.empty() || hidden[row] != all)) revealed.push_back(row);
  if (revealed.empty()) return guessed;
  if (basis.rank() > 0) {
    const double rows_seen = basis.rows() - seen_.unseen();
    const MatrixXd level = mean_rows(basis);
    const MatrixXd y = foreseen(basis, views, pending, gathered, hidden, level, noise, guessed);
    const MatrixXd expected = level * y;  // quantities x columns
    for (const int row : revealed) {
      const int quantity = quantity_of(row);
      double value_expected = 0, expected2 = 0, typical2 = 0, y2 = 0;
      VectorXd value_y = VectorXd::Zero(basis.rank());
      for (int j = 0; j < pending.count(); ++j) {
        if (!hidden.empty() && (hidden[row] >> j & 1)) continue;
        const double value = gathered.column(j)[row], e = expected(quantity, j), w = weights[j];
        value_expected += w * value * e;
        expected2 += w * e * e;
        typical2 += w * y.col(j).squaredNorm() / std::max(rows_seen, 1.0);
        y2 += w * y.col(j).squaredNorm();
        value_y += w * value * y.col(j);
      }
      VectorXd revealed_row = VectorXd::Zero(basis.rank());
      if (expected2 > kDim * kDim * typical2)
        revealed_row = value_expected / expected2 * level.row(quantity).transpose();
      else if (y2 > 0)
        revealed_row = value_y / y2;
      if (revealed_row.norm() < kBrightest) basis.set_row(row, revealed_row);
    }
    for (const MatrixXd& r : basis.restore_orthonormality()) views.multiply(r);
  }
  for (const int row : revealed) seen_.add(row);
  return guessed;
}

template <typename Scalar>
std::shared_ptr<const ShownRows> MissingRows<Scalar>::shown_by(const Pending& pending, int column) const {
  const RowBits& hidden = pending.hidden(column);
  if (hidden.empty() || imputation_ == Imputation::kLeastSquares) return nullptr;
  return std::make_shared<const Shown>(
      shown_rows<Scalar>(witnesses_, hidden, [&](int row) { return pending.value(column, row); }));
}

template <typename Scalar>
std::shared_ptr<const ShownRows> MissingRows<Scalar>::shown_by_both(const Basis& basis, const Views& views, int a,
                                                                    int b) const {
  if (!views.shown(a) && !views.shown(b)) return nullptr;
  Vector explained;  // of the one that shows all rows
  if (!views.shown(a) || !views.shown(b))
    explained = basis.at_rows(witnesses_.rows(), views.coefficients().col(views.shown(a) ? b : a));
  const double fraction = views.weight(b) / (views.weight(a) + views.weight(b));
  return std::make_shared<const Shown>(sheen::shown_by_both<Scalar>(witnesses_, views.shown(a), views.shown(b),
                                                                    explained, static_cast<Scalar>(fraction)));
}

template <typename Scalar>
std::shared_ptr<const ShownRows> MissingRows<Scalar>::shown_without(const Views& views, int view,
                                                                    const ConstVectorRef& column, double weight) const {
  if (!views.shown(view)) return nullptr;
  const double fraction = weight / (views.weight(view) - weight);
  return std::make_shared<const Shown>(sheen::shown_without<Scalar>(
      witnesses_, *views.shown(view), [&](int row) { return column[row]; }, static_cast<Scalar>(fraction)));
}

/// Whether all old rows that a new one lies between were.
template <typename Scalar>
bool MissingRows<Scalar>::was_seen(const RowResampling& by, int row) const {
  const int channels = witnesses_.channels();
  const auto& between = by.between[static_cast<std::size_t>(row / channels)];
  return std::all_of(between.begin(), between.end(),
                     [&](int group) { return seen_.has(group * channels + row % channels); });
}

template <typename Scalar>
void MissingRows<Scalar>::clear_unseen(const RowResampling& by, Matrix& rows) const {
  if (seen_.unseen() == 0) return;
  for (int row = 0; row < by.rows.rows(); ++row)
    if (!was_seen(by, row)) rows.row(row).setZero();
}

template <typename Scalar>
void MissingRows<Scalar>::resample(const RowResampling& by, const Basis& basis, Views& views,
                                   const OnlineSvdOptions& options) {
  const int channels = options.channels, rows = by.rows.rows();
  SeenRows seen(rows);
  for (int row = 0; row < rows; ++row)
    if (was_seen(by, row)) seen.add(row);
  seen_ = std::move(seen);
  planes_ = by.rows;
  witnesses_ = WitnessRows(rows, channels, options.witnesses(rows));
  for (int v = 0; v < views.count(); ++v) {
    const Shown* const before = views.shown(v);
    if (!before) continue;
    RowBits hidden(words_of(rows), 0);
    for (int row = 0; row < rows; ++row)
      for (const int group : by.between[static_cast<std::size_t>(row / channels)])
        if (has_row(before->hidden, group * channels + row % channels)) set_row(hidden, row);
    const Vector y = views.coefficients().col(v);
    views.set_shown(v, std::make_shared<const Shown>(
                           shown_rows<Scalar>(witnesses_, hidden, [&](int row) { return basis.dot(row, y); })));
  }
}

template class MissingRows<float>;
template class MissingRows<double>;

}  // namespace sheen
