// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace sheen {

/// The rows of a factor, which hold one quantity at different places, or three, all rows of one behind all of another.
class RowPlanes {
 public:
  RowPlanes(int rows) : ends_{rows, rows, rows}, count_(1) {}  // NOLINT(google-explicit-constructor): of one
  RowPlanes(int first, int second, int third) : ends_{first, first + second, first + second + third}, count_(3) {}

  int rows() const { return ends_[2]; }
  int count() const { return count_; }
  int of(int row) const { return (row >= ends_[0]) + (row >= ends_[1]); }

 private:
  std::array<int, 3> ends_;
  int count_;
};

}  // namespace sheen
