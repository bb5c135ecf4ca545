// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

inline constexpr std::uint32_t kNoVertex = 0xffffffffu;

/// For each vertex of the mesh the one whose appearance is the best guess for it: itself where `seen` (one entry per
/// vertex) is not 0, else the nearest seen one along the mesh, counted in edges, also where triangles meet at several
/// vertices of one place (a texture's seam). A part of the mesh that touches nothing seen takes the nearest in space.
/// kNoVertex where nothing is seen, and for unseen vertices without a triangle.
std::vector<std::uint32_t> nearest_seen(const Mesh& mesh, const std::vector<std::uint8_t>& seen);
/// The same of vertices in whole numbers (below 2^30), which every machine decides alike.
std::vector<std::uint32_t> nearest_seen(std::span<const std::array<std::int32_t, 3>> places,
                                        std::span<const Triangle> triangles, const std::vector<std::uint8_t>& seen);

}  // namespace sheen
