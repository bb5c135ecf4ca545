// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/pending_columns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

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

template <typename Scalar>
void PendingColumns<Scalar>::make_room(int columns) {
  if (buffer_.cols() != columns) buffer_.resize(row_panels::padded(rows_), columns);
}

template <typename Scalar>
void PendingColumns<Scalar>::add(const Eigen::Ref<const Vector>& column, std::span<const std::uint8_t> known,
                                 double weight) {
  Column pending{.weight = weight, .exponent = 0, .hidden = {}};
  auto kept = buffer_.col(count());
  Scalar peak = copy_and_peak(column.data(), rows_, kept.data());
  kept.tail(kept.size() - rows_).setZero();
  if (!std::isfinite(peak) || (!known.empty() && std::memchr(known.data(), 0, known.size()))) {
    pending.hidden.assign(words_of(rows_), 0);
    for (int row = 0; row < rows_; ++row) {
      if ((known.empty() || known[row]) && std::isfinite(kept[row])) continue;
      kept[row] = 0;
      set_row(pending.hidden, row);
    }
    peak = kept.cwiseAbs().maxCoeff();
  }
  constexpr int kHarmless = 24;
  if (peak > 0 && std::abs(std::ilogb(peak)) > kHarmless) {
    pending.exponent = std::ilogb(peak);
    kept = kept.unaryExpr([&](Scalar x) { return std::ldexp(x, -pending.exponent); }).eval();
  }
  columns_.push_back(std::move(pending));
}

template <typename Scalar>
void PendingColumns<Scalar>::erase(int column) {
  for (int j = column; j + 1 < count(); ++j) buffer_.col(j) = buffer_.col(j + 1);
  columns_.erase(columns_.begin() + column);
}

template <typename Scalar>
void PendingColumns<Scalar>::release() {
  buffer_.resize(row_panels::padded(rows_), 0);
}

template <typename Scalar>
Eigen::VectorXd PendingColumns<Scalar>::buffered_weights() const {
  Eigen::VectorXd weights(count());
  for (int j = 0; j < count(); ++j) weights[j] = std::ldexp(columns_[j].weight, 2 * columns_[j].exponent);
  return weights;
}

template <typename Scalar>
int PendingColumns<Scalar>::known_rows(int column) const {
  int rows = rows_;
  for (const std::uint64_t bits : columns_[column].hidden) rows -= std::popcount(bits);
  return rows;
}

template <typename Scalar>
HiddenPatterns PendingColumns<Scalar>::hidden_patterns() const {
  HiddenPatterns patterns;
  for (int j = 0; j < count(); ++j) {
    if (columns_[j].hidden.empty()) continue;
    if (patterns.empty()) patterns.assign(rows_, 0);
    mark_hidden(columns_[j].hidden, j, patterns);
  }
  return patterns;
}

template <typename Scalar>
std::size_t PendingColumns<Scalar>::bytes() const {
  std::size_t bytes = sizeof(Scalar) * buffer_.size() + sizeof(Column) * columns_.capacity();
  for (const Column& column : columns_) bytes += sizeof(std::uint64_t) * column.hidden.capacity();
  return bytes;
}

template class PendingColumns<float>;
template class PendingColumns<double>;

}  // namespace sheen
