// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// A piece of a surface that is seen as a whole from one side: its triangles face that side and none hides another, so
/// that they can be laid flat by looking at them from there.
struct Chart {
  std::vector<std::uint32_t> triangles;  ///< connected; the first is where it was begun
  Eigen::Matrix<float, 2, 3> plane;      ///< orthonormal rows: object frame to the flat
};

/// Cuts a mesh: every triangle is in exactly one chart. Between a triangle and the side that its chart is seen from are
/// less than 70 degrees, so no length shrinks to less than a third.
std::vector<Chart> cut_into_charts(const Mesh& mesh);

}  // namespace sheen
