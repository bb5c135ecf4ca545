// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace sheen {

/// Half precision (IEEE 754 binary16): 11 bits, rounded to nearest; magnitudes from 6e-8 to 65504.
using Half = Eigen::half;

template <typename Scalar>
void to_half(const Scalar* from, Eigen::Index count, Half* to);
template <typename Scalar>
void from_half(const Half* from, Eigen::Index count, Scalar* to);

/// A matrix between two uses: in half precision, which takes half of the memory of single precision.
class RestingMatrix {
 public:
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }
  const Half* column(Eigen::Index col) const { return values_.data() + col * rows_; }

  /// Rounds a matrix.
  template <typename Scalar>
  void put(const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& matrix);
  /// Its first columns, all of them if they are fewer.
  template <typename Scalar>
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> get(Eigen::Index columns) const;
  template <typename Scalar>
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> get() const {
    return get<Scalar>(cols_);
  }
  /// Inner product of a row's first values with `with`.
  template <typename Scalar>
  Scalar dot(Eigen::Index row, const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& with) const;
  std::size_t bytes() const { return sizeof(Half) * values_.capacity(); }

 private:
  Eigen::Index rows_ = 0, cols_ = 0;
  std::vector<Half> values_;
};

/// A list of numbers of any scale, kept as they are or in half precision times a power of two.
template <typename Scalar>
class KeptValues {
 public:
  KeptValues() = default;
  KeptValues(const std::vector<Scalar>& values, bool in_half);

  std::vector<Scalar> values() const;
  bool in_half() const { return in_half_; }
  std::size_t bytes() const { return bytes_.capacity(); }

 private:
  std::vector<std::byte> bytes_;  ///< the numbers, one after the other
  int exponent_ = 0;              ///< of the power of two that numbers in half precision were divided by
  bool in_half_ = false;
};

}  // namespace sheen
