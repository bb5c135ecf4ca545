// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/vertex_patches.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/geometry/ray_scene.h"

namespace sheen {
namespace {

constexpr int kNormalSmoothing = 2;
constexpr float kSteepest = 1;  // height of a patch's point over its plane, in distances from the middle

std::vector<Eigen::Vector3f> smooth_normals(const Mesh& mesh, const MeshEdges& edges) {
  std::vector<Eigen::Vector3f> normals = smoothed(vertex_normals(mesh), edges, kNormalSmoothing);
  for (Eigen::Vector3f& n : normals) n = n.norm() > 1e-6f ? n.normalized() : Eigen::Vector3f::UnitZ();
  return normals;
}

std::vector<std::uint32_t> all_of(const Mesh& mesh) {
  std::vector<std::uint32_t> vertices(mesh.vertices.size());
  std::iota(vertices.begin(), vertices.end(), 0);
  return vertices;
}

}  // namespace

MeshEdges::MeshEdges(const Mesh& mesh) {
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) edges.emplace_back(std::minmax(t[c], t[(c + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first.assign(mesh.vertices.size() + 1, 0);
  for (const auto& [a, b] : edges) {
    ++first[a + 1];
    ++first[b + 1];
  }
  for (std::size_t v = 0; v + 1 < first.size(); ++v) first[v + 1] += first[v];
  neighbours.resize(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (const auto& [a, b] : edges) {
    neighbours[next[a]++] = b;
    neighbours[next[b]++] = a;
  }
}

std::vector<Eigen::Vector3f> smoothed(std::vector<Eigen::Vector3f> values, const MeshEdges& edges, int times) {
  std::vector<Eigen::Vector3f> before;
  for (; times > 0; --times) {
    before = values;
    for (std::size_t v = 0; v < values.size(); ++v) {
      const auto around = edges.around(v);
      if (around.empty()) continue;
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (const std::uint32_t n : around) sum += before[n];
      values[v] = 0.5f * before[v] + 0.5f / static_cast<float>(around.size()) * sum;
    }
  }
  return values;
}

std::vector<float> pixel_footprints(const Mesh& mesh, std::span<const PosedCamera> cameras) {
  const std::vector<Eigen::Vector3f> normals = vertex_normals(mesh);
  std::vector<float> footprints(mesh.vertices.size());
  tbb::parallel_for(std::size_t{0}, footprints.size(), [&](std::size_t v) {
    double facing = 0, sum = 0, all = 0;
    for (const PosedCamera& view : cameras) {
      const Eigen::Vector3d point = mesh.vertices[v].cast<double>();
      const double footprint =
          std::abs((view.camera_from_object * point).z()) / std::sqrt(view.camera.fx * view.camera.fy);
      all += footprint;
      if (normals[v].cast<double>().dot(camera_centre(view.camera_from_object) - point) <= 0) continue;
      sum += footprint;
      ++facing;
    }
    footprints[v] = static_cast<float>(facing > 0 ? sum / facing : all / static_cast<double>(cameras.size()));
  });
  return footprints;
}

VertexPatches::VertexPatches(const Mesh& mesh, const MeshEdges& edges, std::vector<float> spacing_, int smoothing)
    : VertexPatches(mesh, edges, all_of(mesh), std::move(spacing_), smoothing) {}

VertexPatches::VertexPatches(const Mesh& mesh, const MeshEdges& edges, std::span<const std::uint32_t> vertices,
                             std::vector<float> spacing_, int smoothing)
    : spacing(std::move(spacing_)), offsets(vertices.size() * kPatchPoints) {
  const std::vector<Eigen::Vector3f> all_normals = smooth_normals(mesh, edges);
  for (const std::uint32_t vertex : vertices) normals.push_back(all_normals[vertex]);
  Mesh support = mesh;
  support.vertices = smoothed(mesh.vertices, edges, smoothing);
  const RayScene scene(support);
  tbb::parallel_for(std::size_t{0}, vertices.size(), [&](std::size_t v) {
    const Eigen::Vector3f& middle = support.vertices[vertices[v]];
    const Eigen::Vector3f& n = normals[v];
    const Eigen::Vector3f s = n.unitOrthogonal(), t = n.cross(s);
    const float reach = 2 * spacing[v] * kPatchSide;
    // Height over the plane through the smoothed vertex; `limit` where the surface is too steep or not there.
    const auto height = [&](const Eigen::Vector3f& in_plane) {
      const float limit = kSteepest * in_plane.norm() + 1e-3f * spacing[v];
      const Ray ray{middle + in_plane + reach * n, -n, 0, 2 * reach};
      const Hit hit = scene.intersect(ray);
      return hit ? std::clamp(reach - hit.distance, -limit, limit) : 0.0f;
    };
    for (int j = 0; j < kPatchSide; ++j)
      for (int i = 0; i < kPatchSide; ++i) {
        const Eigen::Vector3f in_plane =
            spacing[v] * (static_cast<float>(i - kPatchSide / 2) * s + static_cast<float>(j - kPatchSide / 2) * t);
        offsets[v * kPatchPoints + j * kPatchSide + i] = in_plane + height(in_plane) * n;
      }
  });
}

}  // namespace sheen
