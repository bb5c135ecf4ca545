// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <map>

#include "common/geometry/mesh.h"

namespace sheen {

/// Square of side 2 * half in the plane z, facing +z, cut into 2 * cells^2 triangles.
inline Mesh square_mesh(float half, float z, int cells) {
  Mesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      mesh.vertices.emplace_back(half * (2.0f * i / cells - 1), half * (2.0f * j / cells - 1), z);
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const auto a = static_cast<std::uint32_t>(j * (cells + 1) + i), b = a + 1, d = a + cells + 1, c = d + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

/// Icosahedron split `levels` times onto a sphere: 20 * 4^levels triangles, outward.
inline Mesh sphere_mesh(float radius, int levels) {
  const float g = (1 + std::sqrt(5.0f)) / 2;
  Mesh mesh;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middle;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, fresh] = middle.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]) / 2);
      return it->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Eigen::Vector3f& v : mesh.vertices) v = radius * v.normalized();
  return mesh;
}

/// Every triangle has vertices of its own, as in a file that lists triangles only.
inline Mesh triangle_soup(const Mesh& mesh) {
  Mesh soup;
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) soup.vertices.push_back(mesh.vertices[v]);
    const auto end = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.push_back({end - 3, end - 2, end - 1});
  }
  return soup;
}

/// Both meshes in one.
inline Mesh joined(Mesh a, const Mesh& b) {
  const auto offset = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({i + offset, j + offset, k + offset});
  return a;
}

}  // namespace sheen
