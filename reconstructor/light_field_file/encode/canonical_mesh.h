// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "common/geometry/mesh.h"
#include "reconstructor/light_field_file/encode/mesh_encoding.h"

namespace sheen {

/// A mesh in the order in which it is stored, vertices on a grid of 2^-16 of its largest side.
struct CanonicalMesh : CodedMesh {
  std::shared_ptr<const Mesh> mesh;
};

CanonicalMesh canonical_mesh(const Mesh& mesh);

}  // namespace sheen
