// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// Orthonormal frame over a vertex: rows are the two tangents and the normal, so `frame * d` is the direction d in
/// local coordinates; its first two entries are the point on the view map, in the unit disc (000 sec. 4.2).
Eigen::Matrix3f hemisphere_frame(const Eigen::Vector3f& normal);

}  // namespace sheen
