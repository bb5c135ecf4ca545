// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/mesh_coding.h"

#include "reconstructor/light_field_file/mesh_coder.h"

namespace sheen {

using namespace mesh_coder;

Mesh GridMesh::mesh() const {
  Mesh mesh;
  mesh.triangles = triangles;
  mesh.vertices.reserve(points.size());
  for (const Point& point : points)
    mesh.vertices.push_back(origin + step * Eigen::Map<const Eigen::Vector3i>(point.data()).cast<float>());
  return mesh;
}

GridMesh decode_mesh(std::string_view bytes) {
  Header header;
  if (bytes.size() < sizeof header) throw std::runtime_error("the mesh is cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  if (header.triangles == 0 || header.triangles > kTrianglesPerByte * bytes.size())
    throw std::runtime_error("the mesh is too short for its triangles");
  GridMesh mesh{.origin = Eigen::Map<const Eigen::Vector3f>(header.origin), .step = header.step};
  if (!(mesh.origin.array().abs() < kLargest).all() || !(mesh.step > 0 && kFurthest * mesh.step < kLargest))
    throw std::runtime_error("the mesh's grid is not valid");
  BitModel bits(kMeshContexts, kMeshMixers);
  ContextDecoder coder(bits, bytes);
  MeshCoder(coder, mesh, nullptr).code(header.triangles);
  return mesh;
}

}  // namespace sheen
