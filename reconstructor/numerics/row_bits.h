// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheen {

/// A bit for each row.
using RowBits = std::vector<std::uint64_t>;

inline std::size_t words_of(int rows) {
  return static_cast<std::size_t>((rows + 63) / 64);
}
inline bool has_row(const RowBits& bits, int row) {
  return bits[row / 64] >> (row % 64) & 1;
}
inline void set_row(RowBits& bits, int row) {
  bits[row / 64] |= std::uint64_t{1} << (row % 64);
}

/// Which columns hide a row, for each row: bit j stands for column j (what `known_grams` takes). Empty: none hides any.
using HiddenPatterns = std::vector<std::uint64_t>;

/// Sets bit `column` of the rows that a column hides.
inline void mark_hidden(const RowBits& hidden, int column, HiddenPatterns& patterns) {
  for (std::size_t word = 0; word < hidden.size(); ++word)
    for (std::uint64_t bits = hidden[word]; bits != 0; bits &= bits - 1)
      patterns[64 * word + std::countr_zero(bits)] |= std::uint64_t{1} << column;
}

}  // namespace sheen
