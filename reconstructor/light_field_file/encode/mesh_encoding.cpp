// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/mesh_encoding.h"

#include "reconstructor/light_field_file/mesh_coder.h"

namespace sheen {

using namespace mesh_coder;

CodedMesh encode_mesh(const GridMesh& mesh) {
  CodedMesh coded{.grid = {.origin = mesh.origin, .step = mesh.step}};
  Source source(mesh);
  BitModel bits(kMeshContexts, kMeshMixers);
  ContextEncoder coder(bits);
  MeshCoder(coder, coded.grid, &source).code(mesh.triangles.size());
  Header header{.triangles = static_cast<std::uint32_t>(mesh.triangles.size()), .step = mesh.step};
  Eigen::Map<Eigen::Vector3f>{header.origin} = mesh.origin;
  coded.bytes = std::string(reinterpret_cast<const char*>(&header), sizeof header) + coder.finish();
  coded.old_vertex = std::move(source.old_vertex);
  coded.old_triangle = std::move(source.old_triangle);
  coded.first_corner = std::move(source.first_corner);
  return coded;
}

}  // namespace sheen
