// SPDX-License-Identifier: Apache-2.0
// What columns do not show: their hidden rows, and rows that are seen for the first time. The class is in
// ring_factor.h.
#include <algorithm>
#include <bit>
#include <cmath>

#include "reconstructor/numerics/imputation.h"
#include "reconstructor/numerics/known_grams.h"
#include "reconstructor/numerics/ring_factor.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using row_panels::columns;

/// Rows of a ring that was dim where it is now bright say little about each other: a channel's mean row is scaled only
/// where it predicts at least this share of a typical value.
constexpr double kDim = 0.04;

/// A revealed row that outshines all others of the ring together as much as this is an event, and starts at zero.
constexpr double kBrightest = 1e3;

/// Of all rows; showing fewer, a column that shows none but new ones does not tell how bright they are.
constexpr double kFewest = 1.0 / 16;

/// Where what is imputed teaches the basis: rows err together (the channels of a sample, neighbours in a highlight), so
/// this many say what one says.
constexpr double kRowsThatErrTogether = 2;

// Between two imputations of the same hidden rows, the columns grow by this factor: the basis has learnt something, and
// the cost a column stays bounded.
constexpr double kGrowth = 1.1;
constexpr std::int64_t kFirst = 10;  // columns; with fewer, the basis knows too little to correct itself

/// Sets bit `column` of the rows that a column hides.
void mark_hidden(const std::vector<std::uint64_t>& hidden, int column, std::vector<std::uint64_t>& patterns) {
  for (std::size_t word = 0; word < hidden.size(); ++word)
    for (std::uint64_t bits = hidden[word]; bits != 0; bits &= bits - 1)
      patterns[64 * word + std::countr_zero(bits)] |= std::uint64_t{1} << column;
}

}  // namespace

template <typename Scalar>
std::vector<std::uint64_t> BasicRingFactor<Scalar>::hidden_patterns() const {
  std::vector<std::uint64_t> patterns;
  for (int j = 0; j < pending(); ++j) {
    if (pending_[j].hidden.empty()) continue;
    if (patterns.empty()) patterns.assign(rows_, 0);
    mark_hidden(pending_[j].hidden, j, patterns);
  }
  return patterns;
}

template <typename Scalar>
MatrixXd BasicRingFactor<Scalar>::pending_projections(std::span<const std::uint64_t> hidden) const {
  MatrixXd y = row_panels::inner_products(columns(basis_, rank_), columns(buffer_, pending()), basis_.rows());
  if (hidden.empty() || rank_ == 0) return y;
  const MatrixXd known = known_grams(columns(basis_, rank_), hidden, pending());
  const MatrixXd covariance = prior(), precision = prior_precision(covariance, row_noise());
  for (int j = 0; j < pending(); ++j) {
    if (pending_[j].hidden.empty()) continue;
    const auto gram = known.col(j).reshaped(rank_, rank_);
    y.col(j) = options_.imputation == Imputation::kLeastSquares ? least_squares_coefficients(gram, y.col(j), covariance)
                                                                : most_probable_coefficients(gram, y.col(j), precision);
  }
  return y;
}

template <typename Scalar>
typename BasicRingFactor<Scalar>::Vector BasicRingFactor<Scalar>::estimate(const ConstVectorRef& column,
                                                                           std::span<const std::uint8_t> known,
                                                                           double noise) const {
  Matrix shown = Matrix::Zero(row_panels::padded(rows_), 1);
  shown.col(0).head(rows_) = column;
  std::vector<std::uint64_t> hidden(rows_, 0);
  bool all_known = true;
  for (int row = 0; row < rows_; ++row) {
    if ((known.empty() || known[row]) && std::isfinite(column[row])) continue;
    all_known = false;
    hidden[row] = 1;
    shown(row, 0) = 0;
  }
  const MatrixXd y = row_panels::inner_products(columns(basis_, rank_), columns(shown, 1), shown.rows());
  if (all_known || rank_ == 0) return y.col(0).template cast<Scalar>();
  const MatrixXd gram = known_grams(columns(basis_, rank_), hidden, 1);
  return stored<Scalar>(
      most_probable_coefficients(gram.reshaped(rank_, rank_), y.col(0), prior_precision(prior(), noise)));
}

/// Calls visit(row) for the witness rows: groups of `channels` neighbouring rows, evenly spread over all.
template <typename Scalar>
template <typename Visit>
void BasicRingFactor<Scalar>::visit_witnesses(Visit visit) const {
  constexpr int kFraction = 32;  // bits
  const int groups = witnesses_ / options_.channels;
  const std::int64_t step = (std::int64_t{rows_ / options_.channels} << kFraction) / groups;
  for (std::int64_t at = 0, group = 0; group < groups; ++group, at += step)
    for (int c = 0; c < options_.channels; ++c) visit(static_cast<int>(at >> kFraction) * options_.channels + c);
}

/// Of a pending column; null when it shows all rows, and where hidden rows are not imputed again.
template <typename Scalar>
std::shared_ptr<const typename BasicRingFactor<Scalar>::Shown> BasicRingFactor<Scalar>::shown_by(int column) const {
  const Pending& pending = pending_[column];
  if (pending.hidden.empty() || options_.imputation == Imputation::kLeastSquares) return nullptr;
  Shown shown{.hidden = pending.hidden, .sketch = {}};
  visit_witnesses([&](int row) {
    if (!bit(shown.hidden, row)) shown.sketch.push_back(std::ldexp(buffer_(row, column), pending.exponent));
  });
  shown.sketch.shrink_to_fit();
  return std::make_shared<const Shown>(std::move(shown));
}

/// Of the mean of two views. `share`: of the removed one.
template <typename Scalar>
std::shared_ptr<const typename BasicRingFactor<Scalar>::Shown> BasicRingFactor<Scalar>::shown_by_both(
    int kept, int removed, Scalar share) const {
  const Shown *a = views_[kept].shown.get(), *b = views_[removed].shown.get();
  if (!a && !b) return nullptr;
  Shown both;
  both.hidden.resize(seen_.size());
  for (std::size_t word = 0; word < both.hidden.size(); ++word)
    both.hidden[word] = (a ? a->hidden[word] : 0) | (b ? b->hidden[word] : 0);
  std::size_t next_a = 0, next_b = 0;
  visit_witnesses([&](int row) {
    const bool in_a = !a || !bit(a->hidden, row), in_b = !b || !bit(b->hidden, row);
    const auto explained = [&](int view) { return basis_.row(row).head(rank_).dot(coefficients_.col(view)); };
    if (in_a && in_b)
      both.sketch.push_back((1 - share) * (a ? a->sketch[next_a] : explained(kept)) +
                            share * (b ? b->sketch[next_b] : explained(removed)));
    next_a += in_a;
    next_b += in_b;
  });
  both.sketch.shrink_to_fit();
  return std::make_shared<const Shown>(std::move(both));
}

/// Of a view that hides rows, when a column is taken out of it. `share`: weight of the column over that of the others.
template <typename Scalar>
std::shared_ptr<const typename BasicRingFactor<Scalar>::Shown> BasicRingFactor<Scalar>::without(
    const View& view, const ConstVectorRef& column, Scalar share) const {
  Shown left = *view.shown;
  auto value = left.sketch.begin();
  visit_witnesses([&](int row) {
    if (bit(left.hidden, row)) return;
    *value += share * (*value - column[row]);
    ++value;
  });
  return std::make_shared<const Shown>(std::move(left));
}

/// B_known^T r of views that hide rows, a column each, where r is what B y misses of the witness rows that they showed.
template <typename Scalar>
typename BasicRingFactor<Scalar>::Matrix BasicRingFactor<Scalar>::missed_projections(std::span<const int> views) const {
  const auto count = static_cast<Eigen::Index>(views.size());
  Matrix basis(witnesses_, rank_), y(rank_, count);
  std::vector<int> rows;
  rows.reserve(static_cast<std::size_t>(witnesses_));
  visit_witnesses([&](int row) { rows.push_back(row); });
  for (int k = 0; k < rank_; ++k)
    for (int w = 0; w < witnesses_; ++w) basis(w, k) = basis_(rows[w], k);
  for (Eigen::Index j = 0; j < count; ++j) y.col(j) = coefficients_.col(views[j]);
  Matrix missed = -basis * y;
  for (Eigen::Index j = 0; j < count; ++j) {
    const Shown& shown = *views_[views[j]].shown;
    auto value = shown.sketch.begin();
    for (int w = 0; w < witnesses_; ++w) missed(w, j) = bit(shown.hidden, rows[w]) ? 0 : missed(w, j) + *value++;
  }
  return basis.transpose() * missed;
}

/// Calls visit(view, known, projection) for the folded views that hide rows: B_known^T B_known and B_known^T c_known.
/// Of the witness rows of a view its sketch knows c, of others B y has to do.
template <typename Scalar>
template <typename Visit>
void BasicRingFactor<Scalar>::visit_masked_views(Visit visit) const {
  std::vector<int> masked;
  for (int v = 0; v < folded_views(); ++v)
    if (views_[v].shown) masked.push_back(v);
  for (std::size_t first = 0; first < masked.size() && rank_ > 0; first += kPatternColumns) {
    const int count = static_cast<int>(std::min<std::size_t>(kPatternColumns, masked.size() - first));
    std::vector<std::uint64_t> patterns(rows_, 0);
    for (int j = 0; j < count; ++j) mark_hidden(views_[masked[first + j]].shown->hidden, j, patterns);
    const Matrix missed = missed_projections(std::span(masked).subspan(first, count));
    const MatrixXd grams = known_grams(columns(basis_, rank_), patterns, count);
    for (int j = 0; j < count; ++j) {
      const int v = masked[first + j];
      const Eigen::Map<const MatrixXd> known(grams.col(j).data(), rank_, rank_);
      const VectorXd projection =
          known * coefficients_.col(v).template cast<double>() + missed.col(j).template cast<double>();
      visit(v, known, projection);
    }
  }
}

template <typename Scalar>
void BasicRingFactor<Scalar>::impute_again_when_due() {
  const auto before = static_cast<double>(std::max(imputed_at_, kFirst));
  if (static_cast<double>(columns_folded_) < kGrowth * before) return;
  imputed_at_ = columns_folded_;
  if (rank_ > 0) impute_again();
}

/// The hidden rows of the folded views anew, from what the basis has learnt since: one step of expectation
/// maximisation.
template <typename Scalar>
void BasicRingFactor<Scalar>::impute_again() {
  if (std::none_of(views_.begin(), views_.end(), [](const View& view) { return view.shown != nullptr; })) return;
  const MatrixXd precision = prior_precision(prior(), kRowsThatErrTogether * row_noise());
  visit_masked_views([&](int v, const Eigen::Map<const MatrixXd>& known, const VectorXd& projection) {
    const VectorXd before = coefficients_.col(v).template cast<double>();
    const VectorXd after = most_probable_coefficients(known, projection, precision);
    const VectorXd change = after - before;
    View& view = views_[v];
    gram_.noalias() += view.weight * (after * after.transpose() - before * before.transpose());
    // Of ||c_known - B_known y||^2.
    const double lost = std::max(-view.lost, change.dot(known * (after + before) - 2 * projection));
    lost_ = std::max(0.0, lost_ + view.weight * lost);
    view.lost += lost;
    coefficients_.col(v) = stored<Scalar>(after);
  });
  gram_ = (0.5 * (gram_ + gram_.transpose())).eval();  // rounding of what is gone again, in two orders
}

template <typename Scalar>
typename BasicRingFactor<Scalar>::Matrix BasicRingFactor<Scalar>::displayed_coefficients() const {
  const int displayed = displayed_rank();
  Matrix y = coefficients_.topRows(displayed);
  if (displayed == 0) return y;  // all is black
  const MatrixXd covariance = prior();
  const double appendix = covariance.diagonal().tail(rank_ - displayed).sum() / rows_;
  const MatrixXd precision = prior_precision(covariance.topLeftCorner(displayed, displayed), row_noise() + appendix);
  visit_masked_views([&](int v, const Eigen::Map<const MatrixXd>& known, const VectorXd& projection) {
    y.col(v) = stored<Scalar>(
        most_probable_coefficients(known.topLeftCorner(displayed, displayed), projection.head(displayed), precision));
  });
  return y;
}

/// What the block's columns look like as far as rows that were seen before tell: rank x pending(). A column that shows
/// none of those looks like the mean of the views, where these are alike and their rows are: taken for black, it would
/// be a term of its own, and what lies between it and the views would be dark. `level`: mean row of each channel.
template <typename Scalar>
MatrixXd BasicRingFactor<Scalar>::foreseen(std::span<const std::uint64_t> hidden, const MatrixXd& level) {
  MatrixXd y = pending_projections(hidden);
  VectorXd mean = VectorXd::Zero(rank_);
  double weight = 0;
  for (int v = 0; v < folded_views(); ++v) {
    mean += views_[v].weight * coefficients_.col(v).template cast<double>();
    weight += views_[v].weight;
  }
  const double mean2 = mean.squaredNorm(),
               level2 = (level * mean).squaredNorm() * (rows_ - unseen_rows_) / level.rows();
  if (hidden.empty() || !(mean2 > 0.5 * weight * gram_.trace() && level2 > 0.5 * mean2)) return y;
  for (int j = 0; j < pending(); ++j) {
    Pending& column = pending_[j];
    bool tells = column.hidden.empty();
    for (std::size_t word = 0; word < column.hidden.size(); ++word)
      tells = tells || (seen_[word] & ~column.hidden[word]) != 0;
    if (tells || column.known_rows(rows_) < kFewest * rows_) continue;
    y.col(j) = std::ldexp(1 / weight, -column.exponent) * mean;
    column.guessed = true;
  }
  return y;
}

/// Gives rows that the basis has never seen the mean row of their channel, scaled to what the block's columns show.
template <typename Scalar>
void BasicRingFactor<Scalar>::reveal_rows(std::span<const double> weight, std::span<const std::uint64_t> hidden) {
  std::vector<int> revealed;
  const std::uint64_t all = (std::uint64_t{1} << pending()) - 1;
  for (int row = 0; row < rows_; ++row)
    if (!seen(row) && (hidden.empty() || hidden[row] != all)) revealed.push_back(row);
  if (revealed.empty()) return;
  if (rank_ > 0) {
    MatrixXd level = MatrixXd::Zero(options_.channels, rank_);
    std::vector<double> rows_of_channel(options_.channels, 0);
    for (int row = 0; row < rows_; ++row) {
      if (!seen(row)) continue;
      level.row(row % options_.channels) += basis_.row(row).head(rank_).template cast<double>();
      rows_of_channel[row % options_.channels] += 1;
    }
    double rows_seen = 0;
    for (int c = 0; c < options_.channels; ++c) {
      level.row(c) /= std::max(rows_of_channel[c], 1.0);
      rows_seen += rows_of_channel[c];
    }
    // Until now a column's unseen rows are hidden rows: those of the basis are 0.
    const MatrixXd y = foreseen(hidden, level);
    const MatrixXd expected = level * y;  // channels x columns
    for (const int row : revealed) {
      const int channel = row % options_.channels;
      double value_expected = 0, expected2 = 0, typical2 = 0, y2 = 0;
      VectorXd value_y = VectorXd::Zero(rank_);
      for (int j = 0; j < pending(); ++j) {
        if (!hidden.empty() && (hidden[row] >> j & 1)) continue;
        const double value = buffer_(row, j), e = expected(channel, j), w = weight[j];
        value_expected += w * value * e;
        expected2 += w * e * e;
        typical2 += w * y.col(j).squaredNorm() / std::max(rows_seen, 1.0);
        y2 += w * y.col(j).squaredNorm();
        value_y += w * value * y.col(j);
      }
      VectorXd revealed_row = VectorXd::Zero(rank_);
      if (expected2 > kDim * kDim * typical2)
        revealed_row = value_expected / expected2 * level.row(channel).transpose();
      else if (y2 > 0)
        revealed_row = value_y / y2;
      if (revealed_row.norm() < kBrightest)
        basis_.row(row).head(rank_) = revealed_row.transpose().template cast<Scalar>();
    }
    restore_orthonormality();
  }
  for (const int row : revealed) seen_[row / 64] |= std::uint64_t{1} << (row % 64);
  unseen_rows_ -= static_cast<int>(revealed.size());
}

// The members that ring_factor.cpp and ring_fold.cpp use.
template std::vector<std::uint64_t> BasicRingFactor<float>::hidden_patterns() const;
template MatrixXd BasicRingFactor<float>::pending_projections(std::span<const std::uint64_t>) const;
template BasicRingFactor<float>::Vector BasicRingFactor<float>::estimate(const ConstVectorRef&,
                                                                         std::span<const std::uint8_t>, double) const;
template BasicRingFactor<float>::Matrix BasicRingFactor<float>::displayed_coefficients() const;
template void BasicRingFactor<float>::reveal_rows(std::span<const double>, std::span<const std::uint64_t>);
template void BasicRingFactor<float>::impute_again_when_due();
template std::shared_ptr<const BasicRingFactor<float>::Shown> BasicRingFactor<float>::shown_by(int) const;
template std::shared_ptr<const BasicRingFactor<float>::Shown> BasicRingFactor<float>::shown_by_both(int, int,
                                                                                                    float) const;
template std::shared_ptr<const BasicRingFactor<float>::Shown> BasicRingFactor<float>::without(const View&,
                                                                                              const ConstVectorRef&,
                                                                                              float) const;
template std::vector<std::uint64_t> BasicRingFactor<double>::hidden_patterns() const;
template MatrixXd BasicRingFactor<double>::pending_projections(std::span<const std::uint64_t>) const;
template BasicRingFactor<double>::Vector BasicRingFactor<double>::estimate(const ConstVectorRef&,
                                                                           std::span<const std::uint8_t>, double) const;
template BasicRingFactor<double>::Matrix BasicRingFactor<double>::displayed_coefficients() const;
template void BasicRingFactor<double>::reveal_rows(std::span<const double>, std::span<const std::uint64_t>);
template void BasicRingFactor<double>::impute_again_when_due();
template std::shared_ptr<const BasicRingFactor<double>::Shown> BasicRingFactor<double>::shown_by(int) const;
template std::shared_ptr<const BasicRingFactor<double>::Shown> BasicRingFactor<double>::shown_by_both(int, int,
                                                                                                      double) const;
template std::shared_ptr<const BasicRingFactor<double>::Shown> BasicRingFactor<double>::without(const View&,
                                                                                                const ConstVectorRef&,
                                                                                                double) const;

}  // namespace sheen
