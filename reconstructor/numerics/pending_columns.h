// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/numerics/row_bits.h"

namespace sheen {

/// The columns of one block while they wait to be folded. Squares of single precision neither overflow nor vanish: a
/// column that is far from one is buffered times a power of two, 2^-exponent. Rows that a column does not show are 0.
template <typename Scalar>
class PendingColumns {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  explicit PendingColumns(int rows) : rows_(rows) {}

  int count() const { return static_cast<int>(columns_.size()); }
  bool empty() const { return columns_.empty(); }
  bool full() const { return count() >= buffer_.cols(); }

  /// Makes room for a block of so many. There must be no columns.
  void make_room(int columns);
  /// `known`: for each row; empty when all are. Rows that are not finite count as unknown. There must be room.
  void add(const Eigen::Ref<const Vector>& column, std::span<const std::uint8_t> known, double weight);
  void erase(int column);  ///< those behind it move up by one
  void clear() { columns_.clear(); }
  void release();  ///< the room. There must be no columns.

  double weight(int column) const { return columns_[column].weight; }
  int exponent(int column) const { return columns_[column].exponent; }
  /// Of the buffered columns: each times its weight's root is what the factor sums up.
  Eigen::VectorXd buffered_weights() const;
  const RowBits& hidden(int column) const { return columns_[column].hidden; }  ///< empty when all rows are known
  int known_rows(int column) const;
  /// Empty when no column hides a row.
  HiddenPatterns hidden_patterns() const;

  /// As it was added, whatever it hides.
  Scalar value(int column, int row) const { return std::ldexp(buffer_(row, column), columns_[column].exponent); }
  /// Padded rows x room, the columns first. A fold leaves nothing of use in it.
  Matrix& buffer() { return buffer_; }
  const Matrix& buffer() const { return buffer_; }
  std::size_t bytes() const;

 private:
  struct Column {
    double weight;
    int exponent;
    RowBits hidden;
  };

  int rows_;
  Matrix buffer_;
  std::vector<Column> columns_;
};

}  // namespace sheen
