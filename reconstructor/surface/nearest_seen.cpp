// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/nearest_seen.h"

#include <algorithm>
#include <deque>
#include <numeric>
#include <span>
#include <tuple>

namespace sheen {
namespace {

using Place = std::array<std::int32_t, 3>;

std::int64_t squared_distance(const Place& a, const Place& b) {
  std::int64_t sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t d = std::int64_t{a[axis]} - b[axis];
    sum += d * d;
  }
  return sum;
}

float squared_distance(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return (a - b).squaredNorm();
}

bool before(const Place& a, const Place& b) {
  return a < b;
}

bool before(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return std::tuple(a.x(), a.y(), a.z()) < std::tuple(b.x(), b.y(), b.z());
}

/// For each vertex another one at the same place, in a circle through all that are there; itself where it is alone.
template <typename Vertex>
std::vector<std::uint32_t> next_at_place(std::span<const Vertex> places) {
  std::vector<std::uint32_t> order(places.size()), next(places.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return before(places[a], places[b]); });
  for (std::size_t first = 0, i = 0; i < order.size(); ++i) {
    const bool last = i + 1 == order.size() || before(places[order[i]], places[order[i + 1]]);
    next[order[i]] = order[last ? first : i + 1];
    if (last) first = i + 1;
  }
  return next;
}

/// The triangles of each vertex, ascending.
class TrianglesRoundVertex {
 public:
  TrianglesRoundVertex(std::size_t vertices, std::span<const Triangle> triangles) : first_(vertices + 1, 0) {
    for (const Triangle& t : triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    triangles_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (const std::uint32_t v : triangles[t]) triangles_[next[v]++] = t;
  }

  std::span<const std::uint32_t> of(std::size_t vertex) const {
    return std::span(triangles_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> triangles_;
};

template <typename Vertex>
std::vector<std::uint32_t> nearest(std::span<const Vertex> places, std::span<const Triangle> triangles,
                                   const std::vector<std::uint8_t>& seen) {
  std::vector<std::uint32_t> source(seen.size(), kNoVertex), all_seen;
  for (std::uint32_t v = 0; v < seen.size(); ++v)
    if (seen[v]) {
      source[v] = v;
      all_seen.push_back(v);
    }
  if (all_seen.empty()) return source;

  std::deque<std::uint32_t> front(all_seen.begin(), all_seen.end());  // breadth first from what is known
  const auto reach = [&](std::uint32_t v, std::uint32_t from) {
    if (source[v] != kNoVertex) return;
    source[v] = from;
    front.push_back(v);
  };
  const TrianglesRoundVertex round_vertex(places.size(), triangles);
  const std::vector<std::uint32_t> same_place = next_at_place(places);
  const auto spread = [&] {
    for (; !front.empty(); front.pop_front()) {
      const std::uint32_t v = front.front();
      for (std::uint32_t next = same_place[v]; next != v; next = same_place[next]) reach(next, source[v]);
      for (const std::uint32_t t : round_vertex.of(v))
        for (const std::uint32_t next : triangles[t]) reach(next, source[v]);
    }
  };
  spread();
  for (std::uint32_t v = 0; v < seen.size(); ++v) {  // parts of the mesh of which nothing was seen
    if (source[v] != kNoVertex || round_vertex.of(v).empty()) continue;
    reach(v, *std::min_element(all_seen.begin(), all_seen.end(), [&](std::uint32_t a, std::uint32_t b) {
            return squared_distance(places[a], places[v]) < squared_distance(places[b], places[v]);
          }));
    spread();
  }
  return source;
}

}  // namespace

std::vector<std::uint32_t> nearest_seen(const Mesh& mesh, const std::vector<std::uint8_t>& seen) {
  return nearest(std::span<const Eigen::Vector3f>(mesh.vertices), std::span<const Triangle>(mesh.triangles), seen);
}

std::vector<std::uint32_t> nearest_seen(std::span<const Place> places, std::span<const Triangle> triangles,
                                        const std::vector<std::uint8_t>& seen) {
  return nearest(places, triangles, seen);
}

}  // namespace sheen
