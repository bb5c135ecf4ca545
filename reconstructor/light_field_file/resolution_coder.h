// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/light_field_file/grid_geometry.h"
#include "reconstructor/light_field_file/resolution_coding.h"
#include "reconstructor/surface/map_resolution.h"

/// How lattice resolutions are coded: one description that writing and reading share.
namespace sheen::resolution_coder {

constexpr int kSmallest = 2, kLargest = std::numeric_limits<std::uint8_t>::max();
constexpr int kContexts = 3;  ///< how the triangle before differed
constexpr std::size_t kRuleBytes = sizeof(std::uint32_t) + 2;

constexpr std::int64_t kEdgePart = 16;       ///< of a step of the grid: unit of edges
constexpr int kRateBits = 20;                ///< samples per step are counted in parts of 2^20
constexpr std::int64_t kMostRate = 1 << 30;  ///< more than that the largest lattice stands on one step

/// Of each triangle, in parts of a step of the grid.
inline std::vector<std::int64_t> longest_edges(const GridMesh& mesh) {
  std::vector<std::int64_t> edges;
  edges.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    std::int64_t longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, squared_distance(mesh.points[triangle[k]], mesh.points[triangle[(k + 1) % 3]]));
    edges.push_back(integer_root(longest * kEdgePart * kEdgePart));
  }
  return edges;
}

/// How resolutions follow from edges (`map_resolution`).
struct Rule {
  std::uint32_t samples_per_step = 0;  ///< in parts of 2^kRateBits
  std::uint8_t smallest = kSmallest;
  std::uint8_t largest = kLargest;  ///< but for triangles that would have less than half of their samples

  int resolution(std::int64_t edge) const {
    constexpr std::int64_t kUnit = kEdgePart << kRateBits;
    const std::int64_t samples = (edge * samples_per_step + kUnit / 2) / kUnit;
    const int side = static_cast<int>(std::min<std::int64_t>(samples, 2 * kLargest)) + 1;
    return std::clamp(side, int{smallest}, std::min(std::max({int{smallest}, int{largest}, (side + 1) / 2}), kLargest));
  }
};

template <typename Coder>
void code_resolutions(Coder& coder, const std::vector<std::int64_t>& edges, const Rule& rule,
                      std::vector<std::uint8_t>& resolutions) {
  std::int32_t last = 0;
  for (std::size_t t = 0; t < edges.size(); ++t) {
    const int expected = rule.resolution(edges[t]);
    last = code_signed(coder, std::min(std::abs(last), kContexts - 1) * kSignedContexts, resolutions[t] - expected);
    if (expected + last < kSmallest || expected + last > kLargest)
      throw std::runtime_error("holds a resolution out of its range");
    resolutions[t] = static_cast<std::uint8_t>(expected + last);
  }
}

}  // namespace sheen::resolution_coder
