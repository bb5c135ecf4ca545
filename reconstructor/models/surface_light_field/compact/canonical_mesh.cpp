// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/canonical_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstructor/models/surface_light_field/compact/mesh_coding.h"

namespace sheen {
namespace {

constexpr float kMostSteps = 65535;

}  // namespace

CanonicalMesh canonical_mesh(const Mesh& mesh) {
  const std::size_t triangles = mesh.triangles.size(), indices = 3 * triangles;
  // The order that the codec likes best. Which triangle is which is found by their corners, which it leaves alone.
  std::vector<unsigned> flat(indices), ordered(indices);
  for (std::size_t t = 0; t < triangles; ++t)
    std::copy(mesh.triangles[t].begin(), mesh.triangles[t].end(), flat.begin() + static_cast<std::ptrdiff_t>(3 * t));
  meshopt_optimizeVertexCache(ordered.data(), flat.data(), indices, mesh.vertices.size());

  // Two triangles of an odd mesh may have the same corners: each is taken once, in their order.
  std::vector<std::uint32_t> by_corners(triangles), sorted(triangles);
  for (std::size_t t = 0; t < triangles; ++t) by_corners[t] = sorted[t] = static_cast<std::uint32_t>(t);
  const auto key_of = [](const std::vector<unsigned>& list, std::uint32_t t) {
    return std::array<unsigned, 3>{list[3 * t], list[3 * t + 1], list[3 * t + 2]};
  };
  std::stable_sort(by_corners.begin(), by_corners.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key_of(flat, a) < key_of(flat, b); });
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key_of(ordered, a) < key_of(ordered, b); });
  CanonicalMesh canonical;
  canonical.old_triangle.resize(triangles);
  for (std::size_t i = 0; i < triangles; ++i) canonical.old_triangle[sorted[i]] = by_corners[i];

  std::vector<unsigned> remap(mesh.vertices.size());
  const std::size_t vertices =
      meshopt_optimizeVertexFetchRemap(remap.data(), ordered.data(), indices, mesh.vertices.size());
  meshopt_remapIndexBuffer(ordered.data(), ordered.data(), indices, remap.data());
  canonical.old_vertex.resize(vertices);
  for (std::size_t v = 0; v < remap.size(); ++v)
    if (remap[v] != ~0u) canonical.old_vertex[remap[v]] = static_cast<std::uint32_t>(v);

  GridMesh grid;
  Eigen::Array3f low = Eigen::Array3f::Constant(INFINITY), high = -low;
  for (const std::uint32_t v : canonical.old_vertex) {
    low = low.min(mesh.vertices[v].array());
    high = high.max(mesh.vertices[v].array());
  }
  grid.origin = low;
  grid.step = std::max((high - low).maxCoeff() / kMostSteps, 1e-30f);
  for (const std::uint32_t v : canonical.old_vertex) {
    const Eigen::Vector3f at = (mesh.vertices[v] - grid.origin) / grid.step;
    grid.points.push_back({static_cast<std::int32_t>(std::lround(at.x())),
                           static_cast<std::int32_t>(std::lround(at.y())),
                           static_cast<std::int32_t>(std::lround(at.z()))});
  }
  for (std::size_t t = 0; t < triangles; ++t)
    grid.triangles.push_back({ordered[3 * t], ordered[3 * t + 1], ordered[3 * t + 2]});
  canonical.bytes = encode_mesh(grid);

  // The codec may begin a triangle at another corner.
  auto decoded = std::make_shared<Mesh>(decode_mesh(canonical.bytes).mesh());
  canonical.first_corner.resize(triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    const Triangle& old = mesh.triangles[canonical.old_triangle[t]];
    const std::uint32_t first = canonical.old_vertex[decoded->triangles[t][0]],
                        second = canonical.old_vertex[decoded->triangles[t][1]];
    std::uint8_t corner = 0;
    while (corner < 2 && !(old[corner] == first && old[(corner + 1) % 3] == second)) ++corner;
    canonical.first_corner[t] = corner;
  }
  canonical.mesh = std::move(decoded);
  return canonical;
}

}  // namespace sheen
