// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// A mesh in the order in which it is stored, vertices on a grid.
struct CanonicalMesh {
  std::shared_ptr<const Mesh> mesh;
  std::vector<std::uint32_t> old_vertex;    ///< for each vertex, its index before
  std::vector<std::uint32_t> old_triangle;  ///< for each triangle
  std::vector<std::uint8_t> first_corner;   ///< for each triangle: which corner it had there its corner 0 was
  std::string bytes;                        ///< as stored: `encode_mesh`
};

/// A step of the grid is an eighth of a pixel where the cameras see the mesh largest, and no less than 2^-16 of the
/// mesh's largest side; without cameras it is this.
CanonicalMesh canonical_mesh(const Mesh& mesh, const std::vector<PosedCamera>& cameras);

}  // namespace sheen
