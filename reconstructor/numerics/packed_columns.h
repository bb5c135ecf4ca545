// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "reconstructor/numerics/fixed_point.h"

namespace sheen {

/// The columns of a matrix as they are, or in fixed point: 16 bits a value, a column in whole multiples of a 32767th of
/// its largest. Of columns that matter less 8 bits, multiples of a 127th.
template <typename Scalar>
class PackedColumns {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  PackedColumns() = default;
  PackedColumns(Matrix exact);  // NOLINT(google-explicit-constructor): it is that matrix
  /// Packing what was unpacked changes nothing.
  static PackedColumns fixed_point(const Matrix& columns) { return fixed_point(columns, columns.cols()); }
  /// `fine`: so many columns take 16 bits, those behind them 8.
  static PackedColumns fixed_point(const Matrix& columns, Eigen::Index fine);
  Matrix& exact();  ///< that it then is, also where it was in fixed point
  /// Others, kept as these are.
  PackedColumns alike(Matrix columns) const;

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return exact_.cols() + static_cast<Eigen::Index>(steps_.size()); }
  Eigen::Index fine() const { return exact_.cols() + fine_; }  ///< columns that do not take 8 bits
  bool empty() const { return cols() == 0; }

  Scalar at(Eigen::Index row, Eigen::Index column) const;
  /// Calls use(column, value) for so many columns, the first; value(row) is what the column holds.
  template <typename Use>
  void visit(Eigen::Index columns, const Use& use) const {
    for (Eigen::Index k = 0; k < columns; ++k) {
      if (steps_.empty())
        use(k, [values = exact_.col(k).data()](Eigen::Index row) { return values[row]; });
      else
        with_codes(k, [&](const auto* codes) {
          use(k, [codes, step = step(k)](Eigen::Index row) { return fixed_value<Scalar>(codes[row], step); });
        });
    }
  }
  /// Of each column with y, which has as many rows, into room for `cols`.
  void inner_products(const Eigen::Ref<const Vector>& y, Eigen::Ref<Vector> products) const;
  Vector column(Eigen::Index column) const;
  Matrix unpacked() const { return unpacked(0, rows_, cols()); }
  /// So many of its rows, and the first of its columns.
  Matrix unpacked(Eigen::Index first_row, Eigen::Index rows, Eigen::Index columns) const;
  /// The same, packed as they are.
  PackedColumns leading(Eigen::Index rows, Eigen::Index columns) const;
  std::size_t bytes() const { return bytes(cols()); }
  std::size_t bytes(Eigen::Index columns) const;  ///< of so many of its columns, the first

 private:
  double step(Eigen::Index column) const { return steps_[static_cast<std::size_t>(column)]; }
  /// Calls `use` with the codes of a column, of their own type.
  template <typename Use>
  auto with_codes(Eigen::Index column, const Use& use) const {
    if (column >= fine_) return use(coarse_codes_.data() + (column - fine_) * rows_);
    return use(codes_.data() + column * rows_);
  }

  Eigen::Index rows_ = 0;
  Matrix exact_;  ///< or, per column:
  std::vector<double> steps_;
  Eigen::Index fine_ = 0;                  ///< columns with 16 bits
  std::vector<std::int16_t> codes_;        ///< of these
  std::vector<std::int8_t> coarse_codes_;  ///< of those behind
};

}  // namespace sheen
