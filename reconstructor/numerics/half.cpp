// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/half.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace sheen {

static_assert(sizeof(Half) == sizeof(std::uint16_t) && std::is_trivially_copyable_v<Half>);

template <typename Scalar>
void to_half(const Scalar* from, Eigen::Index count, Half* to) {
  Eigen::Index i = 0;
#if defined(__F16C__) && defined(EIGEN_VECTORIZE_AVX)  // for which Eigen includes the intrinsics
  if constexpr (std::is_same_v<Scalar, float>)
    for (; i + 8 <= count; i += 8)
      _mm_storeu_si128(reinterpret_cast<__m128i*>(to + i),
                       _mm256_cvtps_ph(_mm256_loadu_ps(from + i), _MM_FROUND_TO_NEAREST_INT));
#endif
  for (; i < count; ++i) to[i] = static_cast<Half>(static_cast<float>(from[i]));
}

template <typename Scalar>
void from_half(const Half* from, Eigen::Index count, Scalar* to) {
  Eigen::Index i = 0;
#if defined(__F16C__) && defined(EIGEN_VECTORIZE_AVX)  // for which Eigen includes the intrinsics
  if constexpr (std::is_same_v<Scalar, float>)
    for (; i + 8 <= count; i += 8)
      _mm256_storeu_ps(to + i, _mm256_cvtph_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from + i))));
#endif
  for (; i < count; ++i) to[i] = static_cast<Scalar>(static_cast<float>(from[i]));
}

template <typename Scalar>
void RestingMatrix::put(const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& matrix) {
  rows_ = matrix.rows();
  cols_ = matrix.cols();
  const auto size = static_cast<std::size_t>(matrix.size());
  if (values_.size() != size) values_ = std::vector<Half>(size);  // no more memory than that: there are many
  to_half(matrix.data(), matrix.size(), values_.data());
}

template <typename Scalar>
Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> RestingMatrix::get(Eigen::Index columns) const {
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> matrix(rows_, std::min(columns, cols_));
  from_half(values_.data(), matrix.size(), matrix.data());
  return matrix;
}

template <typename Scalar>
Scalar RestingMatrix::dot(Eigen::Index row, const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& with) const {
  Scalar sum = 0;
  for (Eigen::Index k = 0; k < with.size(); ++k)
    sum += static_cast<Scalar>(static_cast<float>(values_[static_cast<std::size_t>(k * rows_ + row)])) * with[k];
  return sum;
}

template <typename Scalar>
KeptValues<Scalar>::KeptValues(const std::vector<Scalar>& values, bool in_half) : in_half_(in_half) {
  const auto keep = [this](const auto& numbers) {
    bytes_.resize(numbers.size() * sizeof(numbers[0]));
    if (!numbers.empty()) std::memcpy(bytes_.data(), numbers.data(), bytes_.size());
  };
  if (!in_half) {
    keep(values);
    return;
  }
  Scalar peak = 0;
  for (const Scalar value : values) peak = std::max(peak, std::abs(value));
  if (peak > 0 && std::isfinite(peak)) exponent_ = std::ilogb(peak);
  std::vector<Scalar> scaled(values.size());
  std::transform(values.begin(), values.end(), scaled.begin(), [&](Scalar x) { return std::ldexp(x, -exponent_); });
  std::vector<Half> rounded(values.size());
  to_half(scaled.data(), static_cast<Eigen::Index>(scaled.size()), rounded.data());
  keep(rounded);
}

template <typename Scalar>
std::vector<Scalar> KeptValues<Scalar>::values() const {
  std::vector<Scalar> values(bytes_.size() / (in_half_ ? sizeof(Half) : sizeof(Scalar)));
  if (values.empty()) return values;
  if (!in_half_) {
    std::memcpy(values.data(), bytes_.data(), bytes_.size());
    return values;
  }
  std::vector<Half> rounded(values.size());
  std::memcpy(static_cast<void*>(rounded.data()), bytes_.data(), bytes_.size());
  from_half(rounded.data(), static_cast<Eigen::Index>(values.size()), values.data());
  if (exponent_ != 0)
    for (Scalar& value : values) value = std::ldexp(value, exponent_);
  return values;
}

template void to_half(const float*, Eigen::Index, Half*);
template void to_half(const double*, Eigen::Index, Half*);
template void from_half(const Half*, Eigen::Index, float*);
template void from_half(const Half*, Eigen::Index, double*);
template void RestingMatrix::put(const Eigen::MatrixXf&);
template void RestingMatrix::put(const Eigen::MatrixXd&);
template Eigen::MatrixXf RestingMatrix::get(Eigen::Index) const;
template Eigen::MatrixXd RestingMatrix::get(Eigen::Index) const;
template float RestingMatrix::dot(Eigen::Index, const Eigen::VectorXf&) const;
template double RestingMatrix::dot(Eigen::Index, const Eigen::VectorXd&) const;
template class KeptValues<float>;
template class KeptValues<double>;

}  // namespace sheen
