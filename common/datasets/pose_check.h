// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

namespace sheen {

/// Replaces a nearly orthonormal matrix by the rotation closest to it. Empty, or why it is not a rotation: a
/// reflection, or further than 1e-3 from orthonormal.
std::string make_rotation(Eigen::Matrix3d& matrix);

}  // namespace sheen
