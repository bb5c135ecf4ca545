// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheen {

/// The columns of a matrix, each in fixed point of 8 bits a value where that is exact enough, in 16 bits where it is
/// not, or exactly as it was.
template <typename Scalar>
class PackedColumns {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using ThreeRows = Eigen::Matrix<Scalar, 3, 1>;

  PackedColumns() = default;
  /// Exactly.
  PackedColumns(const Matrix& columns);  // NOLINT(google-explicit-constructor): it is that matrix
  /// `steps`: for each column, how far apart its values may lie in 8 bits; 0 keeps it exactly. Packing what was
  /// unpacked changes nothing.
  PackedColumns(const Matrix& columns, const Eigen::VectorXd& steps);

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return static_cast<Eigen::Index>(columns_.size()); }
  bool empty() const { return columns_.empty(); }
  Eigen::VectorXd steps() const;  ///< that the columns have: by them others are packed alike

  Scalar at(Eigen::Index row, Eigen::Index column) const;
  /// Rows `first` to `first` + 2 times y.
  ThreeRows three_rows_times(Eigen::Index first, const Eigen::Ref<const Vector>& y) const;
  Vector column(Eigen::Index column) const;
  Matrix unpacked() const { return unpacked(rows_, cols()); }
  /// The first of its rows and columns.
  Matrix unpacked(Eigen::Index rows, Eigen::Index columns) const;
  /// The same, packed as they are.
  PackedColumns leading(Eigen::Index rows, Eigen::Index columns) const;
  std::size_t bytes() const;

 private:
  struct Column {
    double step;          ///< 0: its values are not codes
    std::uint32_t first;  ///< byte
    std::uint8_t width;   ///< bytes of a value
  };

  template <typename T>
  const T* values(const Column& column) const {
    return reinterpret_cast<const T*>(bytes_.data() + column.first);
  }
  void unpack(const Column& column, Eigen::Index rows, Scalar* to) const;

  Eigen::Index rows_ = 0;
  std::vector<Column> columns_;
  std::vector<std::byte> bytes_;
};

}  // namespace sheen
