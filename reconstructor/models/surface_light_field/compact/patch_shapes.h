// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/surface/vertex_ring.h"

namespace sheen {

/// Triangles that share one basis.
struct PatchShape {
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> first_sample;  ///< of each triangle among the patch's
  std::uint32_t samples = 0;
  std::vector<std::uint32_t> vertices;  ///< corners of the triangles, ascending
};

/// A mesh cut into patches of neighbouring triangles. It depends on connections and resolutions alone, in whole
/// numbers, so that a reader cuts it the same way.
struct PatchShapes {
  std::vector<PatchShape> patches;
  std::vector<std::uint32_t> patch_of;      ///< per triangle
  std::vector<std::uint32_t> first_sample;  ///< per triangle, in its patch
};
PatchShapes cut_into_patches(const Mesh& mesh, const VertexRings& rings, std::size_t most_triangles);

}  // namespace sheen
