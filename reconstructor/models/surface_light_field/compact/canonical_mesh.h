// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/geometry/mesh.h"

namespace sheen {

/// A mesh in the order in which it is stored, vertices on a grid of 2^-16 of its largest side.
struct CanonicalMesh {
  std::shared_ptr<const Mesh> mesh;
  std::vector<std::uint32_t> old_vertex;    ///< for each vertex, its index before
  std::vector<std::uint32_t> old_triangle;  ///< for each triangle
  std::vector<std::uint8_t> first_corner;   ///< for each triangle: which corner it had there its corner 0 was
  std::string bytes;                        ///< as stored: `encode_mesh`
};

CanonicalMesh canonical_mesh(const Mesh& mesh);

}  // namespace sheen
