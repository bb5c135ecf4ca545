// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/ring_factor.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "reconstructor/numerics/imputation.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

using Eigen::MatrixXd;
using row_panels::columns;

constexpr int kLargestBlock = 32;
constexpr int kWitnessesPerTerm = 12;  // rows: of a column that hides most, the others still outnumber the terms

void require(bool holds, const char* rule) {
  if (!holds) throw std::invalid_argument(rule);
}

/// Copies numbers and returns the largest magnitude; not finite where one of them is not.
template <typename Scalar>
Scalar copy_and_peak(const Scalar* from, Eigen::Index count, Scalar* to) {
  // Magnitudes are in the order of their bits, infinity and NaN above all others.
  using Bits = std::conditional_t<sizeof(Scalar) == sizeof(std::int32_t), std::int32_t, std::int64_t>;
  Bits peak = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    peak = std::max(peak, std::bit_cast<Bits>(from[i]) & std::numeric_limits<Bits>::max());
    to[i] = from[i];
  }
  return std::bit_cast<Scalar>(peak);
}

}  // namespace

int RingFactorOptions::terms_kept() const {
  if (internal_rank > 0) return std::max(internal_rank, max_rank);
  return std::max(max_rank, std::min(32, std::max(2 * max_rank, max_rank + 8)));
}

int RingFactorOptions::witnesses(int rows) const {
  return std::min(rows / channels, kWitnessesPerTerm * terms_kept() / channels + 1) * channels;
}

RingFactorOptions RingFactorOptions::limited_to(int most_displayed, int most_kept, int most_in_block) const {
  RingFactorOptions limited = *this;
  limited.internal_rank = std::min(terms_kept(), most_kept);
  limited.max_rank = std::min({max_rank, most_displayed, most_kept});
  limited.block = std::min(block, most_in_block);
  return limited;
}

template <typename Scalar>
BasicRingFactor<Scalar>::BasicRingFactor(int rows, const RingFactorOptions& options, unsigned phase)
    : options_(options), rows_(rows), phase_(phase), unseen_rows_(rows), seen_((rows + 63) / 64, 0) {
  require(rows > 0, "ring factor: rows must be positive");
  require(options.max_rank >= 1, "ring factor: max_rank must be at least 1");
  require(options.internal_rank == 0 || options.internal_rank >= options.max_rank,
          "ring factor: internal_rank must be 0 or at least max_rank");
  require(options.block >= 1 && options.block <= kLargestBlock, "ring factor: block must be 1..32");
  require(options.tolerance >= 0 && options.tolerance < 1, "ring factor: tolerance must be in [0, 1)");
  require(options.channels >= 1 && options.channels <= rows, "ring factor: channels must be 1..rows");
  witnesses_ = options.witnesses(rows);
  basis_.resize(row_panels::padded(rows), 0);
}

template <typename Scalar>
int BasicRingFactor<Scalar>::Pending::known_rows(int rows) const {
  for (const std::uint64_t bits : hidden) rows -= std::popcount(bits);
  return rows;
}

/// Single columns at first, for what is imputed leans on the columns before; then folds a block apart, at counts that
/// differ with the phase.
template <typename Scalar>
int BasicRingFactor<Scalar>::block_size() const {
  constexpr int kSingles = 8;
  constexpr double kGoldenRatio = 0.6180339887498949;
  if (columns_folded_ < kSingles) return 1;
  const double share = kGoldenRatio * phase_ - std::floor(kGoldenRatio * phase_);  // any few phases in a row fill 0..1
  const int offset = static_cast<int>(options_.block * share);
  const auto since = static_cast<int>((columns_folded_ - kSingles + options_.block - offset) % options_.block);
  return options_.block - since;
}

template <typename Scalar>
typename BasicRingFactor<Scalar>::Reports BasicRingFactor<Scalar>::add(const ConstVectorRef& column,
                                                                       std::span<const std::uint8_t> known,
                                                                       double weight) {
  require(column.size() == rows_, "ring factor: a column must have as many values as the factor has rows");
  require(known.empty() || known.size() == static_cast<std::size_t>(rows_),
          "ring factor: known must have one flag a row");
  require(weight > 0 && std::isfinite(weight), "ring factor: a weight must be positive and finite");
  if (pending_.empty() && buffer_.cols() != block_size()) buffer_.resize(row_panels::padded(rows_), block_size());

  Pending pending{.weight = weight, .exponent = 0, .hidden = {}, .guessed = false};
  auto kept = buffer_.col(this->pending());
  Scalar peak = copy_and_peak(column.data(), rows_, kept.data());
  kept.tail(kept.size() - rows_).setZero();
  if (!std::isfinite(peak) || (!known.empty() && std::memchr(known.data(), 0, known.size()))) {
    pending.hidden.assign(seen_.size(), 0);
    for (int row = 0; row < rows_; ++row) {
      if ((known.empty() || known[row]) && std::isfinite(kept[row])) continue;
      kept[row] = 0;
      pending.hidden[row / 64] |= std::uint64_t{1} << (row % 64);
    }
    peak = kept.cwiseAbs().maxCoeff();
  }
  // Squares of single precision neither overflow nor vanish: what is far from one is scaled by a power of two.
  constexpr int kHarmless = 24;
  if (peak > 0 && std::abs(std::ilogb(peak)) > kHarmless) {
    pending.exponent = std::ilogb(peak);
    kept = kept.unaryExpr([&](Scalar x) { return std::ldexp(x, -pending.exponent); }).eval();
  }
  pending_.push_back(std::move(pending));
  ++columns_added_;
  return this->pending() >= buffer_.cols() ? fold() : Reports{};
}

template <typename Scalar>
typename BasicRingFactor<Scalar>::Reports BasicRingFactor<Scalar>::limit(int max_rank, int internal_rank, int block) {
  require(max_rank >= 1 && internal_rank >= max_rank && block >= 1,
          "ring factor: limits must be positive, and internal_rank at least max_rank");
  Reports reports = fold();
  buffer_.resize(row_panels::padded(rows_), 0);
  options_ = options_.limited_to(max_rank, internal_rank, block);
  turn_to_singular_order();
  return reports;
}

template <typename Scalar>
BasicRingFactor<Scalar> BasicRingFactor<Scalar>::settled() const {
  BasicRingFactor copy = *this;
  copy.fold();
  return copy;
}

template <typename Scalar>
Scalar BasicRingFactor<Scalar>::pending_value(int column, int row) const {
  const Pending& pending = pending_[column];
  if (!pending.hidden.empty() && bit(pending.hidden, row)) return std::numeric_limits<Scalar>::quiet_NaN();
  return std::ldexp(buffer_(row, column), pending.exponent);
}

template <typename Scalar>
typename BasicRingFactor<Scalar>::Matrix BasicRingFactor<Scalar>::pending_coefficients() const {
  MatrixXd y = pending_projections(hidden_patterns());
  for (int j = 0; j < pending(); ++j) y.col(j) *= std::ldexp(1.0, pending_[j].exponent);
  return stored<Scalar>(y);
}

template <typename Scalar>
MatrixXd BasicRingFactor<Scalar>::prior() const {
  double weight = 0;
  for (const View& view : views_) weight += view.weight;
  return gram_ / std::max(weight, 1e-300);
}

template <typename Scalar>
void BasicRingFactor<Scalar>::restore_orthonormality() {
  const auto b = columns(basis_, rank_);
  for (int pass = 0; pass < 2; ++pass) {  // the first leaves rounding times the condition of the rows' Gram matrix
    const Eigen::LLT<MatrixXd> cholesky(row_panels::gram(b, basis_.rows()));
    if (cholesky.info() != Eigen::Success) return;
    // B <- B R^-1, Y <- R Y
    const MatrixXd r = cholesky.matrixU();
    const MatrixXd inverse = cholesky.matrixU().solve(MatrixXd::Identity(rank_, rank_));
    row_panels::combine<Scalar>(b, {}, inverse.template cast<Scalar>(), basis_.rows(),
                                {basis_.data(), basis_.rows(), rank_});
    coefficients_ = (r.template cast<Scalar>() * coefficients_).eval();
    gram_ = (r * gram_ * r.transpose()).eval();
    if (scatter_.size() > 0) scatter_ = (r * scatter_ * r.transpose()).eval();
  }
}

template <typename Scalar>
void BasicRingFactor<Scalar>::merge_views(int kept, int removed) {
  require(kept >= 0 && kept < folded_views() && removed >= 0 && removed < folded_views() && kept != removed,
          "ring factor: only two different folded views can be merged");
  View& a = views_[kept];
  const View& b = views_[removed];
  const double share = b.weight / (a.weight + b.weight);
  const Vector apart = coefficients_.col(removed) - coefficients_.col(kept);
  const Eigen::VectorXd d = apart.template cast<double>();
  const double w = a.weight * share;
  if (scatter_.size() == 0) scatter_ = MatrixXd::Zero(rank_, rank_);
  scatter_.noalias() += w * d * d.transpose();
  a.scatter += b.scatter + w * d.squaredNorm();
  a.lost += share * (b.lost - a.lost);
  a.weight += b.weight;
  a.shown = shown_by_both(kept, removed, static_cast<Scalar>(share));
  coefficients_.col(kept) += static_cast<Scalar>(share) * apart;
  erase_view(removed);
}

template <typename Scalar>
void BasicRingFactor<Scalar>::erase_view(int view) {
  const Eigen::Index behind = coefficients_.cols() - view - 1;
  coefficients_.middleCols(view, behind) = coefficients_.rightCols(behind).eval();
  coefficients_.conservativeResize(rank_, coefficients_.cols() - 1);
  views_.erase(views_.begin() + view);
}

template <typename Scalar>
void BasicRingFactor<Scalar>::remove(int view) {
  require(view >= 0 && view < views(), "ring factor: there is no such view");
  --columns_added_;
  if (const int waiting = view - folded_views(); waiting >= 0) {
    for (int j = waiting; j + 1 < pending(); ++j) buffer_.col(j) = buffer_.col(j + 1);
    pending_.erase(pending_.begin() + waiting);
    return;
  }
  const View& gone = views_[view];
  lost_ = std::max(0.0, lost_ - gone.weight * gone.lost);
  if (gone.scatter > 0) scatter_ *= std::max(0.0, 1 - gone.scatter / std::max(scatter_.trace(), 1e-300));
  erase_view(view);
  rediagonalise();
}

template <typename Scalar>
void BasicRingFactor<Scalar>::take_from(int view, const ConstVectorRef& column, std::span<const std::uint8_t> known,
                                        double weight) {
  require(view >= 0 && view < folded_views(), "ring factor: there is no such folded view");
  View& from = views_[view];
  constexpr double kAlone = 1e-6;  // of the weight: what rounding leaves of weights that were added
  if (from.weight - weight <= kAlone * from.weight) return remove(view);
  --columns_added_;
  const Eigen::VectorXd y = estimate(column, known, row_noise()).template cast<double>();
  const double left = from.weight - weight;
  const Eigen::VectorXd mean = (from.weight * coefficients_.col(view).template cast<double>() - weight * y) / left;
  const Eigen::VectorXd apart = y - mean;
  const double w = weight * left / from.weight;
  if (scatter_.size() > 0) scatter_.noalias() -= w * apart * apart.transpose();
  from.scatter = std::max(0.0, from.scatter - w * apart.squaredNorm());
  lost_ = std::max(0.0, lost_ - weight * from.lost);
  from.weight = left;
  if (from.shown) from.shown = without(from, column, static_cast<Scalar>(weight / left));
  coefficients_.col(view) = mean.template cast<Scalar>();
  rediagonalise();
}

/// G anew from what the views say, then the singular order and the rank that it asks for.
template <typename Scalar>
void BasicRingFactor<Scalar>::rediagonalise() {
  const MatrixXd y = coefficients_.template cast<double>();
  Eigen::VectorXd weight(y.cols());
  for (Eigen::Index v = 0; v < y.cols(); ++v) weight[v] = views_[v].weight;
  gram_ = y * weight.asDiagonal() * y.transpose();
  if (scatter_.size() > 0) gram_ += scatter_;
  turn_to_singular_order();
}

template <typename Scalar>
double BasicRingFactor<Scalar>::displayed_error() const {
  const double all = energy();
  double unshown = lost_;
  for (int i = displayed_rank(); i < rank_; ++i) unshown += gram_(i, i);
  return all > 0 ? std::sqrt(unshown / all) : 0;
}

template <typename Scalar>
std::size_t BasicRingFactor<Scalar>::bytes() const {
  std::size_t bytes = sizeof(Scalar) * (basis_.size() + coefficients_.size() + buffer_.size()) +
                      sizeof(double) * (gram_.size() + scatter_.size() + spectrum_.size()) +
                      sizeof(std::uint64_t) * seen_.capacity() + sizeof(View) * views_.capacity() +
                      sizeof(Pending) * pending_.capacity();
  for (const View& view : views_)
    if (view.shown)
      bytes += sizeof(*view.shown) + sizeof(std::uint64_t) * view.shown->hidden.capacity() +
               sizeof(Scalar) * view.shown->sketch.capacity();
  for (const Pending& pending : pending_) bytes += sizeof(std::uint64_t) * pending.hidden.capacity();
  return bytes;
}

template class BasicRingFactor<float>;
template class BasicRingFactor<double>;

}  // namespace sheen
