// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/resolution_coding.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "reconstructor/coding/context_coder.h"

namespace sheen {
namespace {

constexpr int kSmallest = 2, kLargest = std::numeric_limits<std::uint8_t>::max();
constexpr int kContexts = 3;  ///< how the triangle before differed

/// Of each triangle, in steps of the grid. Whole numbers under one square root: the same on every machine.
std::vector<double> longest_edges(const GridMesh& mesh) {
  std::vector<double> edges;
  edges.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    std::int64_t longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, squared_distance(mesh.points[triangle[k]], mesh.points[triangle[(k + 1) % 3]]));
    edges.push_back(std::sqrt(static_cast<double>(longest)));
  }
  return edges;
}

int expected_resolution(double edge, double samples_per_step) {
  const double samples = std::min(edge * samples_per_step, static_cast<double>(kLargest));
  return std::clamp(static_cast<int>(std::lround(samples)) + 1, kSmallest, kLargest);
}

/// The one of some quantiles of what triangles have that foretells most of them best.
float find_samples_per_step(const std::vector<double>& edges, const std::vector<std::uint8_t>& resolutions) {
  std::vector<float> rates;
  for (std::size_t t = 0; t < edges.size(); ++t)
    if (edges[t] > 0) rates.push_back(static_cast<float>((resolutions[t] - 1) / edges[t]));
  std::sort(rates.begin(), rates.end());
  constexpr std::size_t kQuantiles = 16;
  float best = 0;
  auto least = std::numeric_limits<std::int64_t>::max();
  for (std::size_t q = 1; q < kQuantiles && !rates.empty(); ++q) {
    const float rate = rates[q * rates.size() / kQuantiles];
    std::int64_t off = 0;
    for (std::size_t t = 0; t < edges.size(); ++t)
      off += std::abs(resolutions[t] - expected_resolution(edges[t], rate));
    if (off >= least) continue;
    least = off;
    best = rate;
  }
  return best;
}

template <typename Coder>
void code_resolutions(Coder& coder, const std::vector<double>& edges, float rate,
                      std::vector<std::uint8_t>& resolutions) {
  std::int32_t last = 0;
  for (std::size_t t = 0; t < edges.size(); ++t) {
    const int expected = expected_resolution(edges[t], rate);
    last = code_signed(coder, std::min(std::abs(last), kContexts - 1) * kSignedContexts, resolutions[t] - expected);
    if (expected + last < kSmallest || expected + last > kLargest)
      throw std::runtime_error("holds a resolution out of its range");
    resolutions[t] = static_cast<std::uint8_t>(expected + last);
  }
}

}  // namespace

std::string encode_resolutions(const GridMesh& mesh, const std::vector<std::uint8_t>& resolutions) {
  const std::vector<double> edges = longest_edges(mesh);
  const float rate = find_samples_per_step(edges, resolutions);
  std::vector<std::uint8_t> coded = resolutions;
  BitModel bits(kContexts * kSignedContexts);
  ContextEncoder coder(bits);
  code_resolutions(coder, edges, rate, coded);
  return std::string(reinterpret_cast<const char*>(&rate), sizeof rate) + coder.finish();
}

std::vector<std::uint8_t> decode_resolutions(const GridMesh& mesh, std::string_view bytes) {
  float rate = 0;
  if (bytes.size() < sizeof rate) throw std::runtime_error("is cut short");
  std::memcpy(&rate, bytes.data(), sizeof rate);
  if (!(rate >= 0 && rate < 1e6f)) throw std::runtime_error("holds samples per length that cannot be");
  bytes.remove_prefix(sizeof rate);
  BitModel bits(kContexts * kSignedContexts);
  ContextDecoder coder(bits, bytes);
  std::vector<std::uint8_t> resolutions(mesh.triangles.size());
  code_resolutions(coder, longest_edges(mesh), rate, resolutions);
  return resolutions;
}

}  // namespace sheen
