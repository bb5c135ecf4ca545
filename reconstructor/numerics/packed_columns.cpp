// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/packed_columns.h"

#include <algorithm>
#include <utility>

#include "reconstructor/numerics/fixed_point.h"
#include "reconstructor/numerics/row_panels.h"

namespace sheen {
namespace {

template <typename Code, typename Scalar>
Scalar inner_product(const Code* codes, const Scalar* values, Eigen::Index count) {
  constexpr int lanes = row_panels::VectorOf<Scalar>::kLanes;
  typedef Code Codes __attribute__((vector_size(lanes * sizeof(Code)), may_alias, aligned(sizeof(Code))));
  using Vector = row_panels::Vector<Scalar>;
  Vector sums{};
  Eigen::Index i = 0;
  for (; i + lanes <= count; i += lanes)
    sums += __builtin_convertvector(*reinterpret_cast<const Codes*>(codes + i), Vector) * row_panels::load(values + i);
  Scalar sum = 0;
  for (int lane = 0; lane < lanes; ++lane) sum += sums[lane];
  for (; i < count; ++i) sum += static_cast<Scalar>(codes[i]) * values[i];
  return sum;
}

}  // namespace

template <typename Scalar>
PackedColumns<Scalar>::PackedColumns(Matrix exact) : rows_(exact.rows()), exact_(std::move(exact)) {}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::fixed_point(const Matrix& columns, Eigen::Index fine) {
  if (columns.cols() == 0) return columns;  // which has its rows
  const auto rows = static_cast<std::size_t>(columns.rows());
  PackedColumns packed;
  packed.rows_ = columns.rows();
  packed.fine_ = fine;
  packed.steps_.resize(static_cast<std::size_t>(columns.cols()));
  packed.codes_.resize(rows * static_cast<std::size_t>(fine));
  packed.coarse_codes_.resize(rows * static_cast<std::size_t>(columns.cols() - fine));
  const auto encode = [&]<typename Code>(Eigen::Index k, Code* codes) {
    const Scalar* const values = columns.col(k).data();
    double& step = packed.steps_[static_cast<std::size_t>(k)];
    step = step_to_reach<Code>(largest_magnitude(values, rows));
    encode_fixed(values, rows, step, codes);
  };
  for (Eigen::Index k = 0; k < fine; ++k) encode(k, packed.codes_.data() + k * columns.rows());
  for (Eigen::Index k = fine; k < columns.cols(); ++k)
    encode(k, packed.coarse_codes_.data() + (k - fine) * columns.rows());
  return packed;
}

template <typename Scalar>
typename PackedColumns<Scalar>::Matrix& PackedColumns<Scalar>::exact() {
  if (!steps_.empty()) *this = unpacked();
  return exact_;
}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::alike(Matrix columns) const {
  return steps_.empty() ? PackedColumns(std::move(columns)) : fixed_point(columns, std::min(fine_, columns.cols()));
}

template <typename Scalar>
Scalar PackedColumns<Scalar>::at(Eigen::Index row, Eigen::Index k) const {
  if (steps_.empty()) return exact_(row, k);
  return with_codes(k, [&](const auto* codes) { return fixed_value<Scalar>(codes[row], step(k)); });
}

template <typename Scalar>
void PackedColumns<Scalar>::inner_products(const Eigen::Ref<const Vector>& y, Eigen::Ref<Vector> products) const {
  if (steps_.empty()) {
    products.noalias() = exact_.transpose() * y;
    return;
  }
  for (Eigen::Index k = 0; k < cols(); ++k)
    with_codes(k, [&](const auto* codes) {
      products[k] = static_cast<Scalar>(step(k) * static_cast<double>(inner_product(codes, y.data(), rows_)));
    });
}

template <typename Scalar>
typename PackedColumns<Scalar>::Vector PackedColumns<Scalar>::column(Eigen::Index k) const {
  if (steps_.empty()) return exact_.col(k);
  Vector out(rows_);
  with_codes(k, [&](const auto* codes) { decode_fixed(codes, static_cast<std::size_t>(rows_), step(k), out.data()); });
  return out;
}

template <typename Scalar>
typename PackedColumns<Scalar>::Matrix PackedColumns<Scalar>::unpacked(Eigen::Index first_row, Eigen::Index rows,
                                                                       Eigen::Index columns) const {
  if (steps_.empty()) return exact_.block(first_row, 0, rows, columns);
  Matrix out(rows, columns);
  for (Eigen::Index k = 0; k < columns; ++k)
    with_codes(k, [&](const auto* codes) {
      decode_fixed(codes + first_row, static_cast<std::size_t>(rows), step(k), out.col(k).data());
    });
  return out;
}

template <typename Scalar>
PackedColumns<Scalar> PackedColumns<Scalar>::leading(Eigen::Index rows, Eigen::Index columns) const {
  if (steps_.empty()) return Matrix(exact_.topLeftCorner(rows, columns));
  PackedColumns part;
  part.rows_ = rows;
  part.steps_.assign(steps_.begin(), steps_.begin() + columns);
  const Eigen::Index many = part.fine_ = std::min(fine_, columns);
  part.codes_.resize(static_cast<std::size_t>(rows * many));
  part.coarse_codes_.resize(static_cast<std::size_t>(rows * (columns - many)));
  for (Eigen::Index k = 0; k < many; ++k) std::copy_n(codes_.data() + k * rows_, rows, part.codes_.data() + k * rows);
  for (Eigen::Index k = many; k < columns; ++k)
    std::copy_n(coarse_codes_.data() + (k - fine_) * rows_, rows, part.coarse_codes_.data() + (k - many) * rows);
  return part;
}

template <typename Scalar>
std::size_t PackedColumns<Scalar>::bytes(Eigen::Index columns) const {
  const auto rows = static_cast<std::size_t>(rows_), count = static_cast<std::size_t>(columns);
  if (steps_.empty()) return sizeof(Scalar) * rows * count;
  const auto fine = static_cast<std::size_t>(std::min(columns, fine_));
  return count * sizeof(double) + rows * (sizeof(std::int16_t) * fine + sizeof(std::int8_t) * (count - fine));
}

template class PackedColumns<float>;
template class PackedColumns<double>;

}  // namespace sheen
