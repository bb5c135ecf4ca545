// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// An edge of a triangle, from its vertex of lower number to the other.
struct TriangleEdge {
  std::uint32_t low = 0, high = 0, triangle = 0;
  int from = 0, to = 0;  ///< corners
  bool same_place(const TriangleEdge& other) const { return low == other.low && high == other.high; }
};

/// All of a mesh, by their vertices, then by triangle: those that triangles share stand side by side.
std::vector<TriangleEdge> triangle_edges(const Mesh& mesh);

}  // namespace sheen
