// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace sheen {

/// Numbers of much the same size in 16 bits each: whole multiples of a 32767th of the largest. What is read back is
/// wrong by half of that at most, whether the number itself is large or small.
class FixedPoint {
 public:
  FixedPoint() = default;
  template <typename Scalar>
  explicit FixedPoint(const std::vector<Scalar>& values);

  std::size_t size() const { return codes_.size(); }
  template <typename Scalar>
  Scalar at(std::size_t i) const {
    return static_cast<Scalar>(step_ * codes_[i]);
  }
  std::size_t bytes() const { return sizeof(std::int16_t) * codes_.capacity(); }

 private:
  static constexpr int kLargest = std::numeric_limits<std::int16_t>::max();

  double step_ = 0;
  std::vector<std::int16_t> codes_;
};

template <typename Scalar>
FixedPoint::FixedPoint(const std::vector<Scalar>& values) : codes_(values.size(), 0) {
  double largest = 0;
  for (const Scalar value : values) largest = std::max(largest, std::abs(static_cast<double>(value)));
  if (largest == 0) return;
  step_ = std::max(largest / kLargest, std::numeric_limits<double>::min());
  for (std::size_t i = 0; i < values.size(); ++i)
    codes_[i] = static_cast<std::int16_t>(std::lround(static_cast<double>(values[i]) / step_));
}

}  // namespace sheen
