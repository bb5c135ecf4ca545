// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/numerics/fixed_point.h"
#include "reconstructor/numerics/row_bits.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {

/// The columns of one block while they wait to be folded. Squares of single precision neither overflow nor vanish: a
/// column that is far from one is handed to the fold times a power of two, 2^-exponent. Rows that a column does not
/// show are 0. Packed, values are kept in 16 bits each: 15 of the largest of the column.
template <typename Scalar>
class PendingColumns {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Columns = row_panels::Columns<Scalar>;

  PendingColumns(int rows, bool packed) : rows_(rows), packed_(packed) {}

  int count() const { return static_cast<int>(columns_.size()); }
  bool empty() const { return columns_.empty(); }

  /// `known`: for each row; empty when all are. Rows that are not finite count as unknown.
  void add(const Eigen::Ref<const Vector>& column, std::span<const std::uint8_t> known, double weight);
  void erase(int column);                             ///< those behind it move up by one
  void clear() { columns_ = std::vector<Column>(); }  ///< and what room they had

  double weight(int column) const { return columns_[column].weight; }
  int exponent(int column) const { return columns_[column].exponent; }
  /// Of the columns as the fold sees them: each times its weight's root is what the factor sums up.
  Eigen::VectorXd scaled_weights() const;
  const RowBits& hidden(int column) const { return columns_[column].hidden; }  ///< empty when all rows are known
  int known_rows(int column) const;
  /// Empty when no column hides a row.
  HiddenPatterns hidden_patterns() const;

  /// As it was added; 0 where the column hides the row.
  Scalar value(int column, int row) const {
    return packed_ ? columns_[column].codes.template at<Scalar>(row) : columns_[column].values[row];
  }
  /// All columns side by side, scaled, of padded length. They are the caller's until the same thread asks again, of
  /// whichever factor.
  Columns gathered() const;
  std::size_t bytes() const;

 private:
  struct Column {
    double weight;
    int exponent;
    RowBits hidden;
    std::vector<Scalar> values;  ///< empty where they are packed
    FixedPoint codes;
  };

  int rows_;
  bool packed_;
  std::vector<Column> columns_;
};

}  // namespace sheen
