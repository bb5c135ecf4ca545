// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/resolution_coding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "reconstructor/coding/context_coder.h"
#include "reconstructor/models/surface_light_field/compact/grid_geometry.h"
#include "reconstructor/surface/map_resolution.h"

namespace sheen {
namespace {

constexpr int kSmallest = 2, kLargest = std::numeric_limits<std::uint8_t>::max();
constexpr int kContexts = 3;  ///< how the triangle before differed
constexpr std::size_t kRuleBytes = sizeof(std::uint32_t) + 2;

constexpr std::int64_t kEdgePart = 16;       ///< of a step of the grid: unit of edges
constexpr int kRateBits = 20;                ///< samples per step are counted in parts of 2^20
constexpr std::int64_t kMostRate = 1 << 30;  ///< more than that the largest lattice stands on one step

/// Of each triangle, in parts of a step of the grid.
std::vector<std::int64_t> longest_edges(const GridMesh& mesh) {
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

/// With the samples per step with which most triangles have just the resolution that follows.
Rule best_rule(const std::vector<std::int64_t>& edges, const std::vector<std::uint8_t>& resolutions, int smallest,
               int largest) {
  std::vector<std::pair<double, int>> borders;  // of the samples per step for each triangle: from, and up to
  for (std::size_t t = 0; t < edges.size(); ++t) {
    const int n = resolutions[t];
    if (edges[t] == 0) continue;
    const double edge = static_cast<double>(edges[t]) / kEdgePart;
    const int least_side = n > largest ? 2 * n - 1 : n, most_side = n < largest ? n : 2 * n;
    borders.emplace_back(n == smallest ? 0 : (least_side - 1.5) / edge, 1);
    borders.emplace_back((most_side - 0.5) / edge, -1);
  }
  std::sort(borders.begin(), borders.end());
  Rule rule{0, static_cast<std::uint8_t>(smallest), static_cast<std::uint8_t>(largest)};
  int count = 0, most = 0;
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) {
    count += borders[i].second;
    if (count <= most) continue;
    most = count;
    const double rate = std::ldexp((borders[i].first + borders[i + 1].first) / 2, kRateBits);
    rule.samples_per_step = static_cast<std::uint32_t>(std::min(std::round(rate), double{kMostRate}));
  }
  return rule;
}

/// Where there is a largest number, many triangles have it, whatever their edges are.
Rule find_rule(const std::vector<std::int64_t>& edges, const std::vector<std::uint8_t>& resolutions) {
  const int smallest = *std::min_element(resolutions.begin(), resolutions.end());
  std::array<std::size_t, kLargest + 1> triangles{};
  for (const std::uint8_t resolution : resolutions)
    if (resolution > smallest) ++triangles[resolution];
  const auto most = static_cast<int>(std::max_element(triangles.begin(), triangles.end()) - triangles.begin());
  Rule best;
  auto least = std::numeric_limits<std::int64_t>::max();
  for (const int largest : {kLargest, MapResolutionOptions{}.largest, most}) {
    const Rule rule = best_rule(edges, resolutions, smallest, largest);
    std::int64_t off = 0;
    for (std::size_t t = 0; t < edges.size(); ++t) off += std::abs(resolutions[t] - rule.resolution(edges[t]));
    if (off >= least) continue;
    least = off;
    best = rule;
  }
  return best;
}

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

}  // namespace

std::string encode_resolutions(const GridMesh& mesh, const std::vector<std::uint8_t>& resolutions) {
  const std::vector<std::int64_t> edges = longest_edges(mesh);
  const Rule rule = find_rule(edges, resolutions);
  std::vector<std::uint8_t> coded = resolutions;
  BitModel bits(kContexts * kSignedContexts);
  ContextEncoder coder(bits);
  code_resolutions(coder, edges, rule, coded);
  std::string bytes(kRuleBytes, '\0');
  std::memcpy(bytes.data(), &rule.samples_per_step, sizeof rule.samples_per_step);
  bytes[kRuleBytes - 2] = static_cast<char>(rule.smallest);
  bytes[kRuleBytes - 1] = static_cast<char>(rule.largest);
  return bytes + coder.finish();
}

std::vector<std::uint8_t> decode_resolutions(const GridMesh& mesh, std::string_view bytes) {
  Rule rule;
  if (bytes.size() < kRuleBytes) throw std::runtime_error("is cut short");
  std::memcpy(&rule.samples_per_step, bytes.data(), sizeof rule.samples_per_step);
  rule.smallest = static_cast<std::uint8_t>(bytes[kRuleBytes - 2]);
  rule.largest = static_cast<std::uint8_t>(bytes[kRuleBytes - 1]);
  if (rule.samples_per_step > kMostRate || rule.smallest < kSmallest)
    throw std::runtime_error("holds samples per length that cannot be");
  bytes.remove_prefix(kRuleBytes);
  BitModel bits(kContexts * kSignedContexts);
  ContextDecoder coder(bits, bytes);
  std::vector<std::uint8_t> resolutions(mesh.triangles.size());
  code_resolutions(coder, longest_edges(mesh), rule, resolutions);
  return resolutions;
}

}  // namespace sheen
