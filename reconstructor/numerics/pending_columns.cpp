// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/pending_columns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

/// The rows one after the other; those of runs without values are 0. Returns where they end.
template <typename Scalar>
Scalar* copy_rows(const std::vector<SharedRows<Scalar>>& runs, Scalar* to) {
  for (const SharedRows<Scalar>& run : runs)
    to = run.values ? std::copy_n(run.values.get(), run.rows, to) : std::fill_n(to, run.rows, Scalar{0});
  return to;
}

}  // namespace

template <typename Scalar>
void PendingColumns<Scalar>::add(const Eigen::Ref<const Vector>& column, std::span<const std::uint8_t> known,
                                 double weight) {
  auto values = std::make_shared_for_overwrite<Scalar[]>(static_cast<std::size_t>(rows_));
  Scalar peak = copy_and_peak(column.data(), rows_, values.get());
  if (std::isfinite(peak) && (known.empty() || !std::memchr(known.data(), 0, known.size())))
    return add({{std::move(values), rows_, peak}}, {}, weight);
  std::vector<std::uint8_t> finite_and_known(static_cast<std::size_t>(rows_));
  peak = 0;
  for (int row = 0; row < rows_; ++row) {
    finite_and_known[row] = (known.empty() || known[row]) && std::isfinite(values[row]);
    if (!finite_and_known[row]) values[row] = 0;
    peak = std::max(peak, std::abs(values[row]));
  }
  add({{std::move(values), rows_, peak}}, finite_and_known, weight);
}

template <typename Scalar>
void PendingColumns<Scalar>::add(std::vector<SharedRows<Scalar>> runs, std::span<const std::uint8_t> known,
                                 double weight) {
  Scalar peak = 0;
  for (const SharedRows<Scalar>& run : runs) {
    if (!std::isfinite(run.peak)) {
      Vector column(rows_);
      copy_rows(runs, column.data());
      return add(column, known, weight);
    }
    peak = std::max(peak, run.peak);
  }
  Column pending{.weight = weight, .exponent = 0, .hidden = {}, .runs = std::move(runs)};
  if (!known.empty() && std::memchr(known.data(), 0, known.size())) {
    pending.hidden.assign(words_of(rows_), 0);
    for (int row = 0; row < rows_; ++row)
      if (!known[row]) set_row(pending.hidden, row);
  }
  constexpr int kHarmless = 24;
  if (peak > 0 && std::abs(std::ilogb(peak)) > kHarmless) pending.exponent = std::ilogb(peak);
  columns_.push_back(std::move(pending));
}

template <typename Scalar>
void PendingColumns<Scalar>::erase(int column) {
  columns_.erase(columns_.begin() + column);
}

template <typename Scalar>
Scalar PendingColumns<Scalar>::value(int column, int row) const {
  for (const SharedRows<Scalar>& run : columns_[column].runs) {
    if (row < run.rows) return run.values ? run.values[row] : 0;
    row -= run.rows;
  }
  return 0;
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
    std::fill(copy_rows(column.runs, to), end, Scalar{0});
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
  for (const Column& column : columns_) {
    bytes += sizeof(std::uint64_t) * column.hidden.capacity();
    for (const SharedRows<Scalar>& run : column.runs) bytes += run.bytes();
  }
  return bytes;
}

template class PendingColumns<float>;
template class PendingColumns<double>;

}  // namespace sheen
