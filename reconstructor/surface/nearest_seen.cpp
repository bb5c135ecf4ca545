// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/nearest_seen.h"

#include <algorithm>
#include <deque>
#include <numeric>
#include <span>
#include <tuple>

namespace sheen {
namespace {

/// For each vertex another one at the same place, in a circle through all that are there; itself where it is alone.
std::vector<std::uint32_t> next_at_place(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), next(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t v) {
    const Eigen::Vector3f& at = mesh.vertices[v];
    return std::tuple(at.x(), at.y(), at.z());
  };
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  for (std::size_t first = 0, i = 0; i < order.size(); ++i) {
    const bool last = i + 1 == order.size() || place(order[i + 1]) != place(order[i]);
    next[order[i]] = order[last ? first : i + 1];
    if (last) first = i + 1;
  }
  return next;
}

/// The triangles of each vertex, ascending.
class TrianglesRoundVertex {
 public:
  explicit TrianglesRoundVertex(const Mesh& mesh) : first_(mesh.vertices.size() + 1, 0) {
    for (const Triangle& t : mesh.triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    triangles_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (const std::uint32_t v : mesh.triangles[t]) triangles_[next[v]++] = t;
  }

  std::span<const std::uint32_t> of(std::size_t vertex) const {
    return std::span(triangles_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> triangles_;
};

Eigen::Matrix3Xf places_of(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
  Eigen::Matrix3Xf places(3, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i)
    places.col(static_cast<Eigen::Index>(i)) = mesh.vertices[vertices[i]];
  return places;
}

}  // namespace

std::vector<std::uint32_t> nearest_seen(const Mesh& mesh, const std::vector<std::uint8_t>& seen) {
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
  const TrianglesRoundVertex round_vertex(mesh);
  const std::vector<std::uint32_t> same_place = next_at_place(mesh);
  const auto spread = [&] {
    for (; !front.empty(); front.pop_front()) {
      const std::uint32_t v = front.front();
      for (std::uint32_t next = same_place[v]; next != v; next = same_place[next]) reach(next, source[v]);
      for (const std::uint32_t t : round_vertex.of(v))
        for (const std::uint32_t next : mesh.triangles[t]) reach(next, source[v]);
    }
  };
  spread();
  const Eigen::Matrix3Xf places = places_of(mesh, all_seen);
  for (std::uint32_t v = 0; v < seen.size(); ++v) {  // parts of the mesh of which nothing was seen
    if (source[v] != kNoVertex || round_vertex.of(v).empty()) continue;
    Eigen::Index nearest = 0;
    (places.colwise() - mesh.vertices[v]).colwise().squaredNorm().minCoeff(&nearest);
    reach(v, all_seen[static_cast<std::size_t>(nearest)]);
    spread();
  }
  return source;
}

}  // namespace sheen
