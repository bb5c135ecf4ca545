// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "reconstructor/numerics/fixed_point.h"
#include "reconstructor/numerics/row_bits.h"

namespace sheen {

/// What a view that hides rows showed. Its values are kept of the witness rows alone: enough for the basis to find more
/// in it later, and few enough to keep.
struct ShownRows {
  RowBits hidden;     ///< one of its columns hides the row
  FixedPoint sketch;  ///< values of the witness rows that it showed, in their order

  std::size_t bytes() const { return sizeof(*this) + sizeof(std::uint64_t) * hidden.capacity() + sketch.bytes(); }
};

/// The rows whose values sketches keep: groups of `channels` neighbouring rows, evenly spread over all.
class WitnessRows {
 public:
  /// `count`: a multiple of `channels`.
  WitnessRows(int rows, int channels, int count) : rows_(rows), channels_(channels), count_(count) {}

  int channels() const { return channels_; }
  int count() const { return count_; }

  std::vector<int> rows() const {
    std::vector<int> rows;
    rows.reserve(static_cast<std::size_t>(count_));
    visit([&](int row) { rows.push_back(row); });
    return rows;
  }
  /// Calls visit(row) for each, in ascending order.
  template <typename Visit>
  void visit(Visit visit) const {
    constexpr int kFraction = 32;  // bits
    const int groups = count_ / channels_;
    const std::int64_t step = (std::int64_t{rows_ / channels_} << kFraction) / groups;
    for (std::int64_t at = 0, group = 0; group < groups; ++group, at += step)
      for (int c = 0; c < channels_; ++c) visit(static_cast<int>(at >> kFraction) * channels_ + c);
  }

 private:
  int rows_, channels_, count_;
};

/// Of what shows all but the `hidden` rows, with value(row).
template <typename Scalar, typename Value>
ShownRows shown_rows(const WitnessRows& witnesses, const RowBits& hidden, Value value) {
  std::vector<Scalar> values;
  values.reserve(static_cast<std::size_t>(witnesses.count()));
  witnesses.visit([&](int row) {
    if (!has_row(hidden, row)) values.push_back(value(row));
  });
  return {.hidden = hidden, .sketch = FixedPoint(values)};
}

/// Of the weighted mean of two. One of them may be null: it shows all rows, and at the witnesses what `explained` says.
/// `fraction`: of b in the mean.
template <typename Scalar, typename Explained>
ShownRows shown_by_both(const WitnessRows& witnesses, const ShownRows* a, const ShownRows* b,
                        const Explained& explained, Scalar fraction) {
  ShownRows both;
  both.hidden.resize((a ? a : b)->hidden.size());
  for (std::size_t word = 0; word < both.hidden.size(); ++word)
    both.hidden[word] = (a ? a->hidden[word] : 0) | (b ? b->hidden[word] : 0);
  std::vector<Scalar> values;
  values.reserve(static_cast<std::size_t>(witnesses.count()));
  std::size_t next_a = 0, next_b = 0;
  Eigen::Index witness = 0;
  witnesses.visit([&](int row) {
    const bool in_a = !a || !has_row(a->hidden, row), in_b = !b || !has_row(b->hidden, row);
    if (in_a && in_b)
      values.push_back((1 - fraction) * (a ? a->sketch.at<Scalar>(next_a) : explained[witness]) +
                       fraction * (b ? b->sketch.at<Scalar>(next_b) : explained[witness]));
    next_a += in_a;
    next_b += in_b;
    ++witness;
  });
  both.sketch = FixedPoint(values);
  return both;
}

/// When a column is taken out of the mean. `fraction`: weight of the column over that of the others.
template <typename Scalar, typename Value>
ShownRows shown_without(const WitnessRows& witnesses, const ShownRows& mean, Value value, Scalar fraction) {
  std::vector<Scalar> left;
  left.reserve(mean.sketch.size());
  witnesses.visit([&](int row) {
    if (has_row(mean.hidden, row)) return;
    const Scalar kept = mean.sketch.at<Scalar>(left.size());
    left.push_back(kept + fraction * (kept - value(row)));
  });
  return {.hidden = mean.hidden, .sketch = FixedPoint(left)};
}

}  // namespace sheen
