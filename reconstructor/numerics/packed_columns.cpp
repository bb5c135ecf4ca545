// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_columns.h"

#include <algorithm>
#include <cstring>

#include "reconstructor/numerics/fixed_point.h"

namespace sheen {
namespace {

/// Bytes of so many values, up to where the next column's may begin.
std::uint32_t room_for(Eigen::Index rows, std::size_t width) {
  constexpr std::size_t kAlignment = sizeof(double);
  return static_cast<std::uint32_t>((static_cast<std::size_t>(rows) * width + kAlignment - 1) / kAlignment *
                                    kAlignment);
}

}  // namespace

template <typename Scalar>
PackedColumns<Scalar>::PackedColumns(const Matrix& columns)
    : PackedColumns(columns, Eigen::VectorXd::Zero(columns.cols())) {}

template <typename Scalar>
PackedColumns<Scalar>::PackedColumns(const Matrix& columns, const Eigen::VectorXd& steps) : rows_(columns.rows()) {
  const auto rows = static_cast<std::size_t>(rows_);
  columns_.reserve(static_cast<std::size_t>(columns.cols()));
  std::uint32_t bytes = 0;
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    Column column{.step = 0, .first = bytes, .width = sizeof(Scalar)};
    if (steps[k] > 0) {
      const double largest = largest_magnitude(columns.col(k).data(), rows);
      column.step = step_to_reach<std::int8_t>(largest);
      column.width = 1;
      if (column.step > steps[k]) {
        column.step = step_to_reach<std::int16_t>(largest);
        column.width = 2;
      }
    }
    columns_.push_back(column);
    bytes += room_for(rows_, column.width);
  }
  bytes_.resize(bytes);
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const Column& column = columns_[static_cast<std::size_t>(k)];
    const Scalar* const from = columns.col(k).data();
    std::byte* const to = bytes_.data() + column.first;
    if (column.step == 0)
      std::memcpy(to, from, rows * sizeof(Scalar));
    else if (column.width == 1)
      encode_fixed(from, rows, column.step, reinterpret_cast<std::int8_t*>(to));
    else
      encode_fixed(from, rows, column.step, reinterpret_cast<std::int16_t*>(to));
  }
}

template <typename Scalar>
Eigen::VectorXd PackedColumns<Scalar>::steps() const {
  Eigen::VectorXd steps(cols());
  for (Eigen::Index k = 0; k < cols(); ++k) steps[k] = columns_[static_cast<std::size_t>(k)].step;
  return steps;
}

template <typename Scalar>
Scalar PackedColumns<Scalar>::at(Eigen::Index row, Eigen::Index k) const {
  const Column& column = columns_[static_cast<std::size_t>(k)];
  if (column.step == 0) return values<Scalar>(column)[row];
  return column.width == 1 ? fixed_value<Scalar>(values<std::int8_t>(column)[row], column.step)
                           : fixed_value<Scalar>(values<std::int16_t>(column)[row], column.step);
}

template <typename Scalar>
typename PackedColumns<Scalar>::ThreeRows PackedColumns<Scalar>::three_rows_times(
    Eigen::Index first, const Eigen::Ref<const Vector>& y) const {
  ThreeRows sum = ThreeRows::Zero();
  for (Eigen::Index k = 0; k < y.size(); ++k) sum += y[k] * ThreeRows(at(first, k), at(first + 1, k), at(first + 2, k));
  return sum;
}

template <typename Scalar>
void PackedColumns<Scalar>::unpack(const Column& column, Eigen::Index rows, Scalar* to) const {
  const auto count = static_cast<std::size_t>(rows);
  if (column.step == 0)
    std::memcpy(to, values<Scalar>(column), count * sizeof(Scalar));
  else if (column.width == 1)
    decode_fixed(values<std::int8_t>(column), count, column.step, to);
  else
    decode_fixed(values<std::int16_t>(column), count, column.step, to);
}

template <typename Scalar>
typename PackedColumns<Scalar>::Vector PackedColumns<Scalar>::column(Eigen::Index k) const {
  Vector out(rows_);
  unpack(columns_[static_cast<std::size_t>(k)], rows_, out.data());
  return out;
}

template <typename Scalar>
typename PackedColumns<Scalar>::Matrix PackedColumns<Scalar>::unpacked(Eigen::Index rows, Eigen::Index columns) const {
  Matrix out(rows, columns);
  for (Eigen::Index k = 0; k < columns; ++k) unpack(columns_[static_cast<std::size_t>(k)], rows, out.col(k).data());
  return out;
}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::leading(Eigen::Index rows, Eigen::Index columns) const {
  PackedColumns part;
  part.rows_ = rows;
  part.columns_.assign(columns_.begin(), columns_.begin() + columns);
  std::uint32_t bytes = 0;
  for (Column& column : part.columns_) {
    column.first = bytes;
    bytes += room_for(rows, column.width);
  }
  part.bytes_.resize(bytes);
  for (std::size_t k = 0; k < part.columns_.size(); ++k)
    std::memcpy(part.bytes_.data() + part.columns_[k].first, bytes_.data() + columns_[k].first,
                static_cast<std::size_t>(rows) * columns_[k].width);
  return part;
}

template <typename Scalar>
std::size_t PackedColumns<Scalar>::bytes() const {
  return sizeof(Column) * columns_.capacity() + bytes_.capacity();
}

template class PackedColumns<float>;
template class PackedColumns<double>;

}  // namespace sheen
