// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "reconstructor/numerics/row_planes.h"

namespace sheen {

/// Rows of a factor that shall stand closer together or further apart: other rows for those that it has.
struct RowResampling {
  RowPlanes rows = 0;  ///< new
  /// What columns are in the new rows: old rows x k to new rows x k. Linear.
  std::function<Eigen::MatrixXf(const Eigen::MatrixXf&)> columns;
  /// For each new group of `OnlineSvdOptions::channels` rows: the old groups that it lies between, some of them twice
  /// where they are fewer than three.
  std::vector<std::array<int, 3>> between;
};

}  // namespace sheen
