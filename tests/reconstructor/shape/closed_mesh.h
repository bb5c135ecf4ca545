// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <set>

#include "common/geometry/mesh.h"

namespace sheen {

/// Vertices - edges + triangles: 2 for a ball, 0 for a ring.
inline long euler_characteristic(const Mesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) edges.insert(std::minmax(t[c], t[(c + 1) % 3]));
  return static_cast<long>(mesh.vertices.size()) - static_cast<long>(edges.size()) +
         static_cast<long>(mesh.triangles.size());
}

/// Vertices whose triangles are not one closed fan.
inline std::size_t broken_fans(const Mesh& mesh) {
  std::vector<std::map<std::uint32_t, std::uint32_t>> after(mesh.vertices.size());  // round a vertex, per neighbour
  std::vector<std::size_t> triangles(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) {
      after[t[c]][t[(c + 1) % 3]] = t[(c + 2) % 3];
      ++triangles[t[c]];
    }
  std::size_t broken = 0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    if (after[v].empty()) continue;
    const std::uint32_t first = after[v].begin()->first;
    std::uint32_t at = first;
    std::size_t steps = 0;
    do {
      const auto next = after[v].find(at);
      if (next == after[v].end()) break;
      at = next->second;
      ++steps;
    } while (at != first && steps <= triangles[v]);
    broken += at != first || steps != triangles[v];
  }
  return broken;
}

inline std::size_t without_area(const Mesh& mesh) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    float longest = 0;
    for (int c = 0; c < 3; ++c)
      longest = std::max(longest, (mesh.corner(t, c) - mesh.corner(t, (c + 1) % 3)).squaredNorm());
    count += !(mesh.area_normal(t).norm() > 1e-6f * longest);
  }
  return count;
}

/// Closed, 2-manifold, one piece, seen from outside, every triangle with an area, every vertex used.
inline void expect_closed(const Mesh& mesh) {
  const MeshDiagnosis diagnosis = diagnose(mesh);
  EXPECT_EQ(diagnosis.boundary_edges, 0u);
  EXPECT_EQ(diagnosis.non_manifold_edges, 0u);
  EXPECT_EQ(diagnosis.inconsistent_edges, 0u);
  EXPECT_EQ(diagnosis.isolated_vertices, 0u);
  EXPECT_EQ(diagnosis.components, 1u);
  EXPECT_GT(diagnosis.signed_volume, 0);
  EXPECT_EQ(broken_fans(mesh), 0u);
  EXPECT_EQ(without_area(mesh), 0u);
  EXPECT_EQ(euler_characteristic(mesh) % 2, 0);
}

}  // namespace sheen
