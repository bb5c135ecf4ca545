// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace sheen {

/// Places along a smooth curve through given ones (Catmull-Rom), with as many steps from each to the next. `closed`: on
/// from the last one to the first, which does not come again; else the first and the last are those given. frames >= 2,
/// keys >= 2.
std::vector<Eigen::Vector3d> smooth_path(std::span<const Eigen::Vector3d> keys, int frames, bool closed);

}  // namespace sheen
