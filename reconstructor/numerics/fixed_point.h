// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace sheen {

/// Magnitude of the largest of finite numbers; 0 of none.
template <typename Scalar>
double largest_magnitude(const Scalar* values, std::size_t count) {
  if (count == 0) return 0;
  const Eigen::Map<const Eigen::Array<Scalar, Eigen::Dynamic, 1>> all(values, static_cast<Eigen::Index>(count));
  return static_cast<double>(all.abs().maxCoeff());
}

/// The step by which codes of this type reach numbers up to `largest`.
template <typename Code>
double step_to_reach(double largest) {
  return std::max(largest / std::numeric_limits<Code>::max(), std::numeric_limits<double>::min());
}

/// Numbers as whole multiples of a step, which must reach them; rounded as `Real` computes.
template <typename Real, typename Code, typename Scalar>
void encode_fixed_in(const Scalar* values, std::size_t count, double step, Code* codes) {
  constexpr Real kWhole = Real(1.5) / std::numeric_limits<Real>::epsilon();  // sums with it have no fraction
  const auto inverse = static_cast<Real>(1 / step);
  for (std::size_t i = 0; i < count; ++i)
    codes[i] = static_cast<Code>(static_cast<std::int32_t>(static_cast<Real>(values[i]) * inverse + kWhole - kWhole));
}

template <typename Code, typename Scalar>
void encode_fixed(const Scalar* values, std::size_t count, double step, Code* codes) {
  const auto inverse = static_cast<Scalar>(1 / step);
  if (std::isfinite(inverse) && inverse >= std::numeric_limits<Scalar>::min())
    encode_fixed_in<Scalar>(values, count, step, codes);
  else  // numbers near the smallest or the largest that there are
    encode_fixed_in<double>(values, count, step, codes);
}

/// The number that a code stands for.
template <typename Scalar, typename Code>
Scalar fixed_value(Code code, double step) {
  const auto scale = static_cast<Scalar>(step);
  // But for numbers near the smallest that there are, their own precision will do.
  return scale >= std::numeric_limits<Scalar>::min() ? scale * static_cast<Scalar>(code)
                                                     : static_cast<Scalar>(step * code);
}

template <typename Code, typename Scalar>
void decode_fixed(const Code* codes, std::size_t count, double step, Scalar* values) {
  for (std::size_t i = 0; i < count; ++i) values[i] = fixed_value<Scalar>(codes[i], step);
}

/// Numbers of much the same size in 16 bits each: whole multiples of a 32767th of the largest. What is read back is
/// wrong by half of that at most, whether the number itself is large or small.
class FixedPoint {
 public:
  FixedPoint() = default;
  template <typename Scalar>
  FixedPoint(const Scalar* values, std::size_t count) : codes_(count, 0) {
    const double largest = largest_magnitude(values, count);
    if (largest == 0) return;
    step_ = step_to_reach<std::int16_t>(largest);
    encode_fixed(values, count, step_, codes_.data());
  }
  template <typename Scalar>
  explicit FixedPoint(const std::vector<Scalar>& values) : FixedPoint(values.data(), values.size()) {}

  std::size_t size() const { return codes_.size(); }
  template <typename Scalar>
  Scalar at(std::size_t i) const {
    return fixed_value<Scalar>(codes_[i], step_);
  }
  /// All of them, into room for `size`.
  template <typename Scalar>
  void decode(Scalar* values) const {
    decode_fixed(codes_.data(), codes_.size(), step_, values);
  }
  std::size_t bytes() const { return sizeof(std::int16_t) * codes_.capacity(); }

 private:
  double step_ = 0;
  std::vector<std::int16_t> codes_;
};

}  // namespace sheen
