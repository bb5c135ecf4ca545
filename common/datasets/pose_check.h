// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

namespace sheen {

/// Replaces a nearly orthonormal matrix by the rotation closest to it. Empty, or why it is not a rotation: a
/// reflection, or further than 1e-3 from orthonormal.
std::string make_rotation(Eigen::Matrix3d& matrix);

/// Empty, or that a place of a camera or a light (metres) is not finite or beyond `kLongestLength`.
std::string place_error(const Eigen::Vector3d& place);

}  // namespace sheen
