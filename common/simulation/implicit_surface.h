// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

#include "common/geometry/mesh.h"

namespace sheen {

/// About the signed distance to a surface, negative inside; near the surface its gradient must not vanish. Metres.
using ImplicitFunction = std::function<double(const Eigen::Vector3d&)>;

/// Unit outward normal by central differences.
Eigen::Vector3d implicit_normal(const ImplicitFunction& distance, const Eigen::Vector3d& point);

/// Closed, outward-wound mesh of the surface `distance` = 0 inside the box, of triangles of even size: one vertex per
/// grid cell that the surface crosses (surface nets), then relaxed along the surface and put back on it. Features
/// thinner than two cells are lost. Throws ConfigError when the surface reaches the box's sides.
Mesh mesh_implicit_surface(const ImplicitFunction& distance, const Eigen::Vector3d& box_min,
                           const Eigen::Vector3d& box_max, double cell);

}  // namespace sheen
