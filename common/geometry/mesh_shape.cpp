// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/geometry/mesh.h"

namespace sheen {

std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3f area_normal = mesh.area_normal(t);
    for (const std::uint32_t v : mesh.triangles[t]) normals[v] += area_normal;
  }
  for (Eigen::Vector3f& normal : normals) {
    // In double, tiny and huge meshes keep their normals; Eigen's stableNorm rounds by where in memory its argument is.
    const Eigen::Vector3d exact = normal.cast<double>();
    const double length = exact.norm();
    normal = length > 0 ? Eigen::Vector3f((exact / length).cast<float>()) : Eigen::Vector3f(0, 0, 1);
  }
  return normals;
}

BoundingSphere bounding_sphere(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex.cast<double>().eval());
  if (box.isEmpty()) return {Eigen::Vector3d::Zero(), 0};
  return {box.center(), box.diagonal().norm() / 2};
}

}  // namespace sheen
