// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheen {

/// The columns of a matrix in fixed point: 8 bits a value where that is exact enough for the column, else 16.
template <typename Scalar>
class PackedColumns {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  PackedColumns() = default;
  /// `steps`: for each column, how far apart its values may lie in 8 bits. Packing what was unpacked changes nothing.
  PackedColumns(const Matrix& columns, const Eigen::VectorXd& steps);

  bool empty() const { return columns_.empty(); }
  Eigen::Index rows() const { return rows_; }
  int count() const { return static_cast<int>(columns_.size()); }
  Scalar at(Eigen::Index row, int column) const;
  /// The first `columns` of them.
  Matrix unpacked(int columns) const;
  std::size_t bytes() const;

 private:
  struct Column {
    double step;
    std::uint32_t first;  ///< of its codes
    bool wide;            ///< 16 bits a value
  };

  Eigen::Index rows_ = 0;
  std::vector<Column> columns_;
  std::vector<std::int16_t> codes_;  ///< 8-bit ones two to each
};

}  // namespace sheen
