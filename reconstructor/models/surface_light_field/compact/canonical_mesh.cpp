// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/canonical_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace sheen {
namespace {

constexpr float kGrid = 65535;
using GridPoint = std::array<std::uint16_t, 4>;  // the codec asks for a multiple of four bytes

struct Header {
  std::uint32_t vertices = 0, triangles = 0, index_bytes = 0;
  float origin[3] = {}, step = 1;
};

Eigen::Vector3f on_grid(const GridPoint& point, const Header& header) {
  return Eigen::Map<const Eigen::Vector3f>(header.origin) + header.step * Eigen::Vector3f(point[0], point[1], point[2]);
}

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

  Header header{.vertices = static_cast<std::uint32_t>(vertices), .triangles = static_cast<std::uint32_t>(triangles)};
  Eigen::Array3f low = Eigen::Array3f::Constant(INFINITY), high = -low;
  for (const std::uint32_t v : canonical.old_vertex) {
    low = low.min(mesh.vertices[v].array());
    high = high.max(mesh.vertices[v].array());
  }
  Eigen::Map<Eigen::Array3f>{header.origin} = low;
  header.step = std::max((high - low).maxCoeff() / kGrid, 1e-30f);
  std::vector<GridPoint> points(vertices);
  for (std::size_t v = 0; v < vertices; ++v)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      const float at = (mesh.vertices[canonical.old_vertex[v]][i] - low[i]) / header.step;
      points[v][axis] = static_cast<std::uint16_t>(std::lround(std::clamp(at, 0.0f, kGrid)));
    }

  std::vector<unsigned char> index_bytes(meshopt_encodeIndexBufferBound(indices, vertices));
  index_bytes.resize(meshopt_encodeIndexBuffer(index_bytes.data(), index_bytes.size(), ordered.data(), indices));
  std::vector<unsigned char> vertex_bytes(meshopt_encodeVertexBufferBound(vertices, sizeof(GridPoint)));
  vertex_bytes.resize(
      meshopt_encodeVertexBuffer(vertex_bytes.data(), vertex_bytes.size(), points.data(), vertices, sizeof(GridPoint)));
  header.index_bytes = static_cast<std::uint32_t>(index_bytes.size());
  canonical.bytes.assign(reinterpret_cast<const char*>(&header), sizeof header);
  canonical.bytes.append(index_bytes.begin(), index_bytes.end());
  canonical.bytes.append(vertex_bytes.begin(), vertex_bytes.end());

  // The codec may begin a triangle at another corner.
  auto decoded = std::make_shared<Mesh>(decode_mesh(canonical.bytes));
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

Mesh decode_mesh(std::string_view bytes) {
  Header header;
  if (bytes.size() < sizeof header) throw std::runtime_error("the mesh is cut short");
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  // A triangle takes a byte at least; vertices that no triangle has are not stored.
  if (header.index_bytes > bytes.size() || header.triangles > header.index_bytes ||
      header.vertices > 3 * std::uint64_t{header.triangles})
    throw std::runtime_error("the mesh's sizes contradict each other");
  if (!Eigen::Map<const Eigen::Array3f>(header.origin).allFinite() || !(header.step > 0 && header.step < 1e30f))
    throw std::runtime_error("the mesh's grid is not valid");
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  Mesh mesh;
  mesh.triangles.resize(header.triangles);
  static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));
  std::vector<GridPoint> points(header.vertices);
  if (header.triangles == 0 ||
      meshopt_decodeIndexBuffer(mesh.triangles.data(), 3 * std::size_t{header.triangles}, sizeof(std::uint32_t), data,
                                header.index_bytes) != 0 ||
      meshopt_decodeVertexBuffer(points.data(), points.size(), sizeof(GridPoint), data + header.index_bytes,
                                 bytes.size() - header.index_bytes) != 0)
    throw std::runtime_error("the mesh is damaged");
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle)
      if (v >= header.vertices) throw std::runtime_error("a triangle has a corner that is not a vertex");
  mesh.vertices.reserve(points.size());
  for (const GridPoint& point : points) mesh.vertices.push_back(on_grid(point, header));
  return mesh;
}

}  // namespace sheen
