// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/resolution_encoding.h"

#include "reconstructor/light_field_file/resolution_coder.h"

namespace sheen {

using namespace resolution_coder;

namespace {

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

}  // namespace sheen
