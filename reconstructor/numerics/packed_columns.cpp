// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_columns.h"

#include <algorithm>
#include <utility>

#include "reconstructor/numerics/fixed_point.h"

namespace sheen {

template <typename Scalar>
PackedColumns<Scalar>::PackedColumns(Matrix exact) : rows_(exact.rows()), exact_(std::move(exact)) {}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::fixed_point(const Matrix& columns) {
  if (columns.cols() == 0) return columns;  // which has its rows
  const auto rows = static_cast<std::size_t>(columns.rows());
  PackedColumns packed;
  packed.rows_ = columns.rows();
  packed.steps_.resize(static_cast<std::size_t>(columns.cols()));
  packed.codes_.resize(static_cast<std::size_t>(columns.size()));
  for (Eigen::Index k = 0; k < columns.cols(); ++k) {
    const Scalar* const values = columns.col(k).data();
    double& step = packed.steps_[static_cast<std::size_t>(k)];
    step = step_to_reach<std::int16_t>(largest_magnitude(values, rows));
    encode_fixed(values, rows, step, packed.codes_.data() + k * columns.rows());
  }
  return packed;
}

template <typename Scalar>
typename PackedColumns<Scalar>::Matrix& PackedColumns<Scalar>::exact() {
  if (!steps_.empty()) *this = unpacked();
  return exact_;
}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::alike(Matrix columns) const {
  return steps_.empty() ? PackedColumns(std::move(columns)) : fixed_point(columns);
}

template <typename Scalar>
Scalar PackedColumns<Scalar>::at(Eigen::Index row, Eigen::Index k) const {
  if (steps_.empty()) return exact_(row, k);
  return fixed_value<Scalar>(codes_of(k)[row], steps_[static_cast<std::size_t>(k)]);
}

template <typename Scalar>
typename PackedColumns<Scalar>::ThreeRows PackedColumns<Scalar>::three_rows_times(
    Eigen::Index first, const Eigen::Ref<const Vector>& y) const {
  if (steps_.empty()) return exact_.template middleRows<3>(first).leftCols(y.size()) * y;
  ThreeRows sum = ThreeRows::Zero();
  for (Eigen::Index k = 0; k < y.size(); ++k) sum += y[k] * ThreeRows(at(first, k), at(first + 1, k), at(first + 2, k));
  return sum;
}

template <typename Scalar>
void PackedColumns<Scalar>::inner_products(const Eigen::Ref<const Vector>& y, Eigen::Ref<Vector> products) const {
  if (steps_.empty()) {
    products.noalias() = exact_.transpose() * y;
    return;
  }
  constexpr Eigen::Index kAtOnce = 128;  // rows, decoded into what stays in the nearest cache
  Eigen::Matrix<Scalar, kAtOnce, 1> some;
  for (Eigen::Index k = 0; k < cols(); ++k) {
    Scalar sum = 0;
    for (Eigen::Index row = 0; row < rows_; row += kAtOnce) {
      const Eigen::Index count = std::min(kAtOnce, rows_ - row);
      decode_fixed(codes_of(k) + row, static_cast<std::size_t>(count), steps_[static_cast<std::size_t>(k)],
                   some.data());
      sum += some.head(count).dot(y.segment(row, count));
    }
    products[k] = sum;
  }
}

template <typename Scalar>
typename PackedColumns<Scalar>::Vector PackedColumns<Scalar>::column(Eigen::Index k) const {
  if (steps_.empty()) return exact_.col(k);
  Vector out(rows_);
  decode_fixed(codes_of(k), static_cast<std::size_t>(rows_), steps_[static_cast<std::size_t>(k)], out.data());
  return out;
}

template <typename Scalar>
typename PackedColumns<Scalar>::Matrix PackedColumns<Scalar>::unpacked(Eigen::Index first_row, Eigen::Index rows,
                                                                       Eigen::Index columns) const {
  if (steps_.empty()) return exact_.block(first_row, 0, rows, columns);
  Matrix out(rows, columns);
  for (Eigen::Index k = 0; k < columns; ++k)
    decode_fixed(codes_of(k) + first_row, static_cast<std::size_t>(rows), steps_[static_cast<std::size_t>(k)],
                 out.col(k).data());
  return out;
}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::leading(Eigen::Index rows, Eigen::Index columns) const {
  if (steps_.empty()) return Matrix(exact_.topLeftCorner(rows, columns));
  PackedColumns part;
  part.rows_ = rows;
  part.steps_.assign(steps_.begin(), steps_.begin() + columns);
  part.codes_.resize(static_cast<std::size_t>(rows * columns));
  for (Eigen::Index k = 0; k < columns; ++k) std::copy_n(codes_of(k), rows, part.codes_.data() + k * rows);
  return part;
}

template <typename Scalar>
std::size_t PackedColumns<Scalar>::bytes() const {
  return sizeof(Scalar) * static_cast<std::size_t>(exact_.size()) + sizeof(double) * steps_.capacity() +
         sizeof(std::int16_t) * codes_.capacity();
}

template class PackedColumns<float>;
template class PackedColumns<double>;

}  // namespace sheen
