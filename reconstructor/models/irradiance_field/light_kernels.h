// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reconstructor/numerics/point_kriging.h"

namespace sheen {

/// Kernels that a scene chooses from, by how well they predict each of its images from the others. Distances are those
/// between lights, or between their places as seen along the camera's axis.
std::vector<PointKernel> light_kernels(const Eigen::Matrix3Xd& lights);

}  // namespace sheen
