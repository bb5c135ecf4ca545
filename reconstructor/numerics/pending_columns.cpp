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

/// The largest magnitude: not finite where a number is not.
template <typename Scalar>
Scalar peak_of(const Scalar* values, std::size_t count) {
  // Magnitudes are in the order of their bits, infinity and NaN above all others.
  using Bits = std::conditional_t<sizeof(Scalar) == sizeof(std::int32_t), std::int32_t, std::int64_t>;
  Bits peak = 0;
  for (std::size_t i = 0; i < count; ++i)
    peak = std::max(peak, std::bit_cast<Bits>(values[i]) & std::numeric_limits<Bits>::max());
  return std::bit_cast<Scalar>(peak);
}

/// Makes the values 0 that are not known or not finite.
template <typename Scalar>
RowBits hide_unknown(std::span<const std::uint8_t> known, std::vector<Scalar>& values) {
  RowBits hidden(words_of(static_cast<int>(values.size())), 0);
  for (std::size_t row = 0; row < values.size(); ++row) {
    const bool shown = (known.empty() || known[row]) && std::isfinite(values[row]);
    values[row] = shown ? values[row] : 0;
    hidden[row / 64] |= std::uint64_t{!shown} << (row % 64);
  }
  return hidden;
}

}  // namespace

template <typename Scalar>
void PendingColumns<Scalar>::add(const Eigen::Ref<const Vector>& column, std::span<const std::uint8_t> known,
                                 double weight) {
  const auto rows = static_cast<std::size_t>(rows_);
  Column pending{.weight = weight, .exponent = 0, .hidden = {}, .values = {}, .codes = {}};
  const Scalar* values = column.data();
  Scalar peak = peak_of(values, rows);
  const bool all_known = std::isfinite(peak) && (known.empty() || !std::memchr(known.data(), 0, known.size()));
  if (!all_known || !packed_) {
    pending.values.assign(values, values + rows);
    values = pending.values.data();
  }
  if (!all_known) {
    pending.hidden = hide_unknown(known, pending.values);
    peak = peak_of(values, rows);
  }
  constexpr int kHarmless = 24;
  if (peak > 0 && std::abs(std::ilogb(peak)) > kHarmless) pending.exponent = std::ilogb(peak);
  if (packed_) {
    pending.codes = FixedPoint(values, rows);
    pending.values = std::vector<Scalar>();
  }
  columns_.reserve(columns_.size() + 1);  // no more than that: there are many patches
  columns_.push_back(std::move(pending));
}

template <typename Scalar>
void PendingColumns<Scalar>::erase(int column) {
  columns_.erase(columns_.begin() + column);
}

template <typename Scalar>
typename PendingColumns<Scalar>::Columns PendingColumns<Scalar>::gathered() const {
  thread_local std::vector<Scalar> buffer;
  const Eigen::Index length = row_panels::padded(rows_);
  const auto needed = static_cast<std::size_t>(length) * columns_.size();
  if (buffer.size() < needed) buffer.resize(needed);
  Scalar* to = buffer.data();
  for (const Column& column : columns_) {
    Scalar* const end = to + length;
    if (packed_)
      column.codes.decode(to);
    else
      std::copy(column.values.begin(), column.values.end(), to);
    std::fill(to + rows_, end, Scalar{0});
    if (column.exponent != 0)
      std::transform(end - length, end, end - length, [&](Scalar x) { return std::ldexp(x, -column.exponent); });
    to = end;
  }
  return {buffer.data(), length, count()};
}

template <typename Scalar>
Eigen::VectorXd PendingColumns<Scalar>::scaled_weights() const {
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
  std::size_t bytes = sizeof(Column) * columns_.capacity();
  for (const Column& column : columns_)
    bytes += sizeof(std::uint64_t) * column.hidden.capacity() + sizeof(Scalar) * column.values.capacity() +
             column.codes.bytes();
  return bytes;
}

template class PendingColumns<float>;
template class PendingColumns<double>;

}  // namespace sheen
