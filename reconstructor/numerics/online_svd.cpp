// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/online_svd.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "reconstructor/numerics/imputation.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

void require(bool holds, const char* rule) {
  if (!holds) throw std::invalid_argument(rule);
}

const OnlineSvdOptions& valid(const OnlineSvdOptions& options, int rows) {
  require_valid(options, rows);
  return options;
}

}  // namespace

template <typename Scalar>
BasicOnlineSvd<Scalar>::BasicOnlineSvd(const RowPlanes& rows, const OnlineSvdOptions& options, unsigned phase)
    : options_(valid(options, rows.rows())),
      phase_(phase),
      basis_(rows.rows()),
      missing_(rows, options),
      pending_(rows.rows(), options.sensor_variance > 0) {}

/// Single columns at first, for what is imputed leans on the columns before; then folds a block apart, at counts that
/// differ with the phase.
template <typename Scalar>
int BasicOnlineSvd<Scalar>::block_size() const {
  constexpr int kSingles = 8;
  constexpr double kGoldenRatio = 0.6180339887498949;
  if (columns_folded_ < kSingles) return 1;
  const double fraction =
      kGoldenRatio * phase_ - std::floor(kGoldenRatio * phase_);  // any few phases in a row fill 0..1
  const int offset = static_cast<int>(options_.block * fraction);
  const auto since = static_cast<int>((columns_folded_ - kSingles + options_.block - offset) % options_.block);
  return options_.block - since;
}

template <typename Scalar>
typename BasicOnlineSvd<Scalar>::Reports BasicOnlineSvd<Scalar>::add(const ConstVectorRef& column,
                                                                     std::span<const std::uint8_t> known,
                                                                     double weight) {
  require(column.size() == rows(), "online SVD: a column must have as many values as the factor has rows");
  require(known.empty() || known.size() == static_cast<std::size_t>(rows()),
          "online SVD: known must have one flag per row");
  require(weight > 0 && std::isfinite(weight), "online SVD: a weight must be positive and finite");
  if (pending_.empty()) block_due_ = block_size();
  pending_.add(column, known, weight);
  ++columns_added_;
  return pending() >= block_due_ ? fold() : Reports{};
}

template <typename Scalar>
typename BasicOnlineSvd<Scalar>::Reports BasicOnlineSvd<Scalar>::fold() {
  Reports reports;
  if (pending_.empty()) return reports;
  basis_.open();
  missing_.impute_again_when_due(basis_, views_, columns_folded_, row_noise());
  const Eigen::VectorXd weights = pending_.scaled_weights();
  const HiddenPatterns hidden = pending_.hidden_patterns();
  std::vector<typename FoldedViews<Scalar>::Arrival> arrivals;
  arrivals.reserve(static_cast<std::size_t>(pending()));
  for (int j = 0; j < pending(); ++j)
    arrivals.push_back({pending_.weight(j), pending_.exponent(j), missing_.shown_by(pending_, j)});

  const auto columns = pending_.gathered();
  const std::uint64_t guessed = missing_.reveal(basis_, views_, pending_, columns, weights, hidden, row_noise());
  const Eigen::MatrixXd y = missing_.project(basis_, views_, pending_, columns, hidden, row_noise());
  const bool first = rank() == 0;
  const Fold fold = basis_.fold(columns, weights, y, hidden, options_);
  views_.follow(fold.rotation);
  reports.reserve(static_cast<std::size_t>(pending()));
  for (int j = 0; j < pending(); ++j) {
    const ColumnReport& brought = reports.emplace_back(report(fold, j, first || (guessed >> j & 1) != 0));
    if (!brought.first && brought.known_rows > 0)
      arrivals[j].unexplained = brought.residual_norm * brought.residual_norm / brought.known_rows;
    follow_noise(arrivals[j].unexplained);
  }
  views_.append(fold, std::move(arrivals));
  columns_folded_ += pending();
  pending_.clear();
  close_basis();
  return reports;
}

/// What a column brought.
template <typename Scalar>
ColumnReport BasicOnlineSvd<Scalar>::report(const Fold& fold, int column, bool first) const {
  ColumnReport report;
  report.norm = std::ldexp(std::sqrt(fold.norm2[column]), pending_.exponent(column));
  report.residual_norm = std::ldexp(std::sqrt(fold.residual2[column]), pending_.exponent(column));
  report.known_rows = pending_.known_rows(column);
  report.first = first;
  return report;
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::follow_noise(double unexplained) {
  if (unexplained < 0) return;
  row_noise_ = predicted_ ? std::lerp(unexplained, row_noise_, options_.residual_memory) : unexplained;
  predicted_ = true;
}

/// As if only the views that are left had come: one bad image makes a running mean large, and with it everything that
/// is imputed thereafter would tend to the mean of the views.
template <typename Scalar>
void BasicOnlineSvd<Scalar>::forget_noise_of_the_removed() {
  row_noise_ = 0;
  predicted_ = false;
  for (int view = 0; view < folded_views(); ++view) follow_noise(views_.unexplained(view));
}

template <typename Scalar>
typename BasicOnlineSvd<Scalar>::Reports BasicOnlineSvd<Scalar>::limit(int max_rank, int internal_rank, int block) {
  require(max_rank >= 1 && internal_rank >= max_rank && block >= 1,
          "online SVD: limits must be positive, and internal_rank at least max_rank");
  Reports reports = fold();
  options_ = options_.limited_to(max_rank, internal_rank, block);
  turn_to_singular_order();
  return reports;
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::resample(const RowResampling& by) {
  require(pending_.empty(), "online SVD: no column may be pending when its rows are replaced");
  basis_.open();
  const double share = static_cast<double>(by.rows.rows()) / rows();
  Matrix resampled = by.columns(basis_.leading(rank()).template cast<float>()).template cast<Scalar>();
  missing_.clear_unseen(by, resampled);
  views_.multiply(basis_.replace_rows(resampled));
  views_.rows_replaced(share);
  missing_.resample(by, basis_, views_, options_);
  pending_ = PendingColumns<Scalar>(by.rows.rows(), options_.sensor_variance > 0);
  turn_to_singular_order();
}

template <typename Scalar>
BasicOnlineSvd<Scalar> BasicOnlineSvd<Scalar>::settled() const {
  BasicOnlineSvd copy = *this;
  copy.fold();
  return copy;
}

template <typename Scalar>
Scalar BasicOnlineSvd<Scalar>::pending_value(int column, int row) const {
  const RowBits& hidden = pending_.hidden(column);
  if (!hidden.empty() && has_row(hidden, row)) return std::numeric_limits<Scalar>::quiet_NaN();
  return pending_.value(column, row);
}

template <typename Scalar>
typename BasicOnlineSvd<Scalar>::Matrix BasicOnlineSvd<Scalar>::pending_coefficients() const {
  if (pending_.empty()) return Matrix(rank(), 0);
  const SvdBasis<Scalar> open = opened();
  Eigen::MatrixXd y =
      missing_.project(open, views_, pending_, pending_.gathered(), pending_.hidden_patterns(), row_noise());
  for (int j = 0; j < pending(); ++j) y.col(j) *= std::ldexp(1.0, pending_.exponent(j));
  return stored<Scalar>(y);
}

template <typename Scalar>
typename BasicOnlineSvd<Scalar>::Vector BasicOnlineSvd<Scalar>::estimate(const ConstVectorRef& column,
                                                                         std::span<const std::uint8_t> known,
                                                                         double noise) const {
  const SvdBasis<Scalar> open = opened();
  return missing_.estimate(open, views_, column, known, noise);
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::merge_views(int kept, int removed) {
  require(kept >= 0 && kept < folded_views() && removed >= 0 && removed < folded_views() && kept != removed,
          "online SVD: only two different folded views can be merged");
  views_.merge(kept, removed, missing_.shown_by_both(basis_, views_, kept, removed));
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::remove(int view) {
  require(view >= 0 && view < views(), "online SVD: there is no such view");
  --columns_added_;
  if (const int waiting = view - folded_views(); waiting >= 0) return pending_.erase(waiting);
  basis_.count_lost(views_.weight(view), -views_.lost(view));
  views_.remove(view);
  forget_noise_of_the_removed();
  rediagonalise();
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::take_from(int view, const ConstVectorRef& column, std::span<const std::uint8_t> known,
                                       double weight) {
  require(view >= 0 && view < folded_views(), "online SVD: there is no such folded view");
  constexpr double kAlone = 1e-6;  // of the weight: what rounding leaves of weights that were added
  if (views_.weight(view) - weight <= kAlone * views_.weight(view)) return remove(view);
  --columns_added_;
  const Eigen::VectorXd y = estimate(column, known, row_noise()).template cast<double>();
  basis_.count_lost(weight, -views_.lost(view));
  views_.take_from(view, y, weight, missing_.shown_without(views_, view, column, weight));
  rediagonalise();
}

/// G again from what the views say, then the singular order and the rank that it asks for.
template <typename Scalar>
void BasicOnlineSvd<Scalar>::rediagonalise() {
  basis_.set_gram(views_.gram());
  turn_to_singular_order();
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::turn_to_singular_order() {
  basis_.open();
  views_.follow(basis_.restore_order(options_));
  close_basis();
}

template <typename Scalar>
void BasicOnlineSvd<Scalar>::close_basis() {
  if (options_.sensor_variance > 0) basis_.close(options_.tolerance);
}

template <typename Scalar>
std::size_t BasicOnlineSvd<Scalar>::bytes() const {
  return basis_.bytes() + views_.bytes() + missing_.bytes() + pending_.bytes();
}

template <typename Scalar>
double BasicOnlineSvd<Scalar>::bytes_for(double rows, double terms, double columns, double views, double sketched,
                                         bool packed) {
  constexpr double kViewEntry = 140;                  // its line in the ledger, and the head of what it showed
  const double padded = rows + row_panels::kPadding;  // to whole vectors
  const double view = kViewEntry + padded / 8 + sizeof(std::int16_t) * sketched;
  const double value = packed ? sizeof(std::int16_t) : sizeof(Scalar);
  const double grams = packed ? 1.5 : 2;  // G, of which one triangle will do, and how merged views scattered
  return value * padded * (terms + columns) + sizeof(Scalar) * terms * views +
         sizeof(double) * (grams * terms * terms + terms) + padded / 8 + views * view;
}

template class BasicOnlineSvd<float>;
template class BasicOnlineSvd<double>;

}  // namespace sheen
