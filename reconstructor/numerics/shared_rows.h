// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <type_traits>

namespace sheen {

/// A run of a column's rows that several factors may hold at once: what an image shows of a triangle is part of a
/// column of three rings, and waits for the folds of all three in one place. Null values: the column shows none of the
/// rows. Values are 0 where it does not show a row.
template <typename Scalar>
struct SharedRows {
  std::shared_ptr<const Scalar[]> values;
  int rows = 0;
  Scalar peak = 0;  ///< largest magnitude; not finite where a value is not

  /// Of memory, divided among all who hold the values.
  std::size_t bytes() const {
    constexpr std::size_t kCounters = 32;  // beside the values, with what the allocator needs
    const auto held = sizeof(Scalar) * static_cast<std::size_t>(rows) + kCounters;
    return sizeof(*this) + (values ? held / static_cast<std::size_t>(values.use_count()) : 0);
  }
};

/// Copies numbers; SharedRows::peak of them.
template <typename Scalar>
Scalar copy_and_peak(const Scalar* from, Eigen::Index count, Scalar* to) {
  // Magnitudes are in the order of their bits, infinity and NaN above all others.
  using Bits = std::conditional_t<sizeof(Scalar) == sizeof(std::int32_t), std::int32_t, std::int64_t>;
  Bits peak = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    peak = std::max(peak, std::bit_cast<Bits>(from[i]) & std::numeric_limits<Bits>::max());
    to[i] = from[i];
  }
  return std::bit_cast<Scalar>(peak);
}

/// A copy of values of which none is hidden.
template <typename Derived>
SharedRows<typename Derived::Scalar> shared_rows(const Eigen::PlainObjectBase<Derived>& values) {
  using Scalar = typename Derived::Scalar;
  const auto copy = std::make_shared_for_overwrite<Scalar[]>(static_cast<std::size_t>(values.size()));
  const Scalar peak = copy_and_peak(values.data(), values.size(), copy.get());
  return {copy, static_cast<int>(values.size()), peak};
}

}  // namespace sheen
