// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_columns.h"

#include "reconstructor/numerics/fixed_point.h"

namespace sheen {

template <typename Scalar>
PackedColumns<Scalar>::PackedColumns(const Matrix& columns, const Eigen::VectorXd& steps) : rows_(columns.rows()) {
  const auto rows = static_cast<std::size_t>(rows_);
  columns_.reserve(static_cast<std::size_t>(columns.cols()));
  std::uint32_t words = 0;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const double largest = largest_magnitude(columns.col(k).data(), rows);
    const double narrow = step_to_reach<std::int8_t>(largest);
    const bool wide = narrow > steps[k];
    columns_.push_back({wide ? step_to_reach<std::int16_t>(largest) : narrow, words, wide});
    words += static_cast<std::uint32_t>(wide ? rows : (rows + 1) / 2);
  }
  codes_.resize(words);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const Column& column = columns_[static_cast<std::size_t>(k)];
    std::int16_t* const to = codes_.data() + column.first;
    if (column.wide)
      encode_fixed(columns.col(k).data(), rows, column.step, to);
    else
      encode_fixed(columns.col(k).data(), rows, column.step, reinterpret_cast<std::int8_t*>(to));
  }
}

template <typename Scalar>
Scalar PackedColumns<Scalar>::at(Eigen::Index row, int column) const {
  const Column& c = columns_[static_cast<std::size_t>(column)];
  const std::int16_t* const codes = codes_.data() + c.first;
  return static_cast<Scalar>(c.step * (c.wide ? codes[row] : reinterpret_cast<const std::int8_t*>(codes)[row]));
}

template <typename Scalar>
typename PackedColumns<Scalar>::Matrix PackedColumns<Scalar>::unpacked(int columns) const {
  Matrix out(rows_, columns);
  for (int k = 0; k < columns; ++k) {
    const Column& column = columns_[static_cast<std::size_t>(k)];
    const std::int16_t* const codes = codes_.data() + column.first;
    const auto rows = static_cast<std::size_t>(rows_);
    if (column.wide)
      decode_fixed(codes, rows, column.step, out.col(k).data());
    else
      decode_fixed(reinterpret_cast<const std::int8_t*>(codes), rows, column.step, out.col(k).data());
  }
  return out;
}

template <typename Scalar>
std::size_t PackedColumns<Scalar>::bytes() const {
  return sizeof(Column) * columns_.capacity() + sizeof(std::int16_t) * codes_.capacity();
}

template class PackedColumns<float>;
template class PackedColumns<double>;

}  // namespace sheen
