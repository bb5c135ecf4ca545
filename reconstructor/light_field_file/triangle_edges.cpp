// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/triangle_edges.h"

#include <algorithm>
#include <tuple>

namespace sheen {

std::vector<TriangleEdge> triangle_edges(const Mesh& mesh) {
  std::vector<TriangleEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int next = (c + 1) % 3;
      const std::uint32_t a = mesh.triangles[t][static_cast<std::size_t>(c)],
                          b = mesh.triangles[t][static_cast<std::size_t>(next)];
      edges.push_back(a < b ? TriangleEdge{a, b, t, c, next} : TriangleEdge{b, a, t, next, c});
    }
  std::sort(edges.begin(), edges.end(), [](const TriangleEdge& a, const TriangleEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

}  // namespace sheen
