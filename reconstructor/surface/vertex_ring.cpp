// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/vertex_ring.h"

#include <algorithm>

namespace sheen {

LatticeStencil lattice_stencil(int n, float u, float v) {
  const float fu = std::clamp(u, 0.0f, 1.0f) * (n - 1),
              fv = std::clamp(v, 0.0f, 1.0f - std::clamp(u, 0.0f, 1.0f)) * (n - 1);
  const int i = std::min(static_cast<int>(fu), n - 2);
  const int j = std::min(static_cast<int>(fv), n - 2 - i);
  const float a = fu - i, b = fv - j;
  if (a + b <= 1 || i + j + 2 > n - 1) {    // the lower half of the cell, the only one at the lattice's long edge
    const float s = std::max(1.0f, a + b);  // rounding may put a point a hair outside
    return {{lattice_index(n, i, j), lattice_index(n, i + 1, j), lattice_index(n, i, j + 1)},
            {std::max(0.0f, 1 - a - b), a / s, b / s}};
  }
  return {{lattice_index(n, i + 1, j + 1), lattice_index(n, i, j + 1), lattice_index(n, i + 1, j)},
          {a + b - 1, 1 - a, 1 - b}};
}

VertexRings::VertexRings(const Mesh& mesh, std::vector<std::uint8_t> resolution) : resolution_(std::move(resolution)) {
  const std::size_t vertices = mesh.vertices.size(), triangles = mesh.triangles.size();
  first_.assign(vertices + 1, 0);
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) ++first_[v + 1];
  for (std::size_t v = 0; v < vertices; ++v) first_[v + 1] += first_[v];

  members_.resize(3 * triangles);
  membership_.resize(3 * triangles);
  ring_samples_.assign(vertices, 0);
  triangle_first_.assign(triangles + 1, 0);
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    const int samples = lattice_samples(resolution_[t]);
    triangle_first_[t + 1] = triangle_first_[t] + samples;
    for (std::uint8_t c = 0; c < 3; ++c) {
      const std::uint32_t v = mesh.triangles[t][c];
      membership_[3 * t + c] = static_cast<std::uint32_t>(next[v]);
      members_[next[v]++] = {t, c, static_cast<std::uint32_t>(ring_samples_[v])};
      ring_samples_[v] += samples;
    }
  }
}

}  // namespace sheen
