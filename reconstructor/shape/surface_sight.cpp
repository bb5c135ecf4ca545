// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/surface_sight.h"

#include <algorithm>

#include "common/geometry/ray_scene.h"
#include "common/parallel/for_each.h"
#include "reconstructor/surface/vertex_visibility.h"

namespace sheen {
namespace {

constexpr float kLeastCosine = 0.3f;  // of a view with the normal: flatter ones tell no depth
constexpr float kNearer = 0.98f;
constexpr int kEnough = 3;          // views, for a depth that two agree about
constexpr double kFacesDown = 0.5;  // cosine

/// How many cameras look straight enough at each vertex.
std::vector<int> cameras_at(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals,
                            std::span<const PosedCamera> cameras) {
  const RayScene scene(mesh);
  std::vector<std::vector<std::uint8_t>> seen(cameras.size());
  in_parallel(cameras.size(), [&](std::size_t i) {
    Rigid3 pose = cameras[i].camera_from_object;
    pose.translation = pose * mesh.origin;
    seen[i] = visible_vertices(mesh, scene, cameras[i].camera, pose, {}, kNearer);
    const Eigen::Vector3f eye = camera_centre(pose).cast<float>();
    for (std::size_t v = 0; v < seen[i].size(); ++v)
      if (!((eye - mesh.vertices[v]).normalized().dot(normals[v]) > kLeastCosine)) seen[i][v] = 0;
  });
  std::vector<int> count(mesh.vertices.size(), 0);
  for (const std::vector<std::uint8_t>& by_one : seen)
    for (std::size_t v = 0; v < count.size(); ++v) count[v] += by_one[v] != 0 ? 1 : 0;
  return count;
}

}  // namespace

SurfaceSight sight_of(const Mesh& mesh, std::span<const PosedCamera> cameras, const Eigen::Vector3d& up) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  const std::vector<int> looking = cameras_at(mesh, normals, cameras);
  SurfaceSight sight;
  double all = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d area = mesh.area_normal(t).cast<double>() / 3;
    for (const std::uint32_t v : mesh.triangles[t]) {
      all += area.norm();
      if (mesh.evidence[v] == ShapeEvidence::kSeen) continue;
      if (looking[v] >= kEnough) {
        sight.smooth += area.norm();
      } else if (-area.dot(up) > kFacesDown * area.norm()) {
        sight.underneath += area.norm();
      } else {
        sight.aside += area.norm();
        sight.faces_aside += area;
      }
    }
  }
  for (double* share : {&sight.smooth, &sight.underneath, &sight.aside}) *share /= std::max(all, 1e-300);
  sight.faces_aside.normalize();
  return sight;
}

}  // namespace sheen
