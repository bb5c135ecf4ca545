// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/fill_unseen.h"

#include <algorithm>
#include <deque>
#include <numeric>
#include <tuple>

namespace sheen {
namespace {

constexpr int kLatticeNeighbours[6][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};

/// Mean basis row of the seen samples, a channel: 3 x rank.
Eigen::MatrixXf mean_rows(const RingSnapshot& ring) {
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, ring.rank());
  int seen = 0;
  for (std::size_t s = 0; s < ring.shown.size(); ++s)
    if (ring.shown[s]) {
      mean += ring.basis.middleRows<3>(static_cast<Eigen::Index>(3 * s));
      ++seen;
    }
  return mean / static_cast<float>(std::max(seen, 1));
}

/// A ring of `samples` that has the neighbour's mean colour everywhere.
std::shared_ptr<const RingSnapshot> flat_copy(const RingSnapshot& neighbour, int samples) {
  auto flat = std::make_shared<RingSnapshot>(neighbour);
  flat->basis = mean_rows(neighbour).replicate(samples, 1);
  // All samples count as seen while the guess spreads; the caller marks them unseen at the end.
  flat->shown.assign(static_cast<std::size_t>(samples), 255);
  return flat;
}

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

Eigen::Matrix3Xf places_of(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
  Eigen::Matrix3Xf places(3, static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i)
    places.col(static_cast<Eigen::Index>(i)) = mesh.vertices[vertices[i]];
  return places;
}

}  // namespace

void fill_unseen_samples(RingSnapshot& ring, std::span<const int> resolution) {
  if (ring.rank() == 0 || std::find(ring.shown.begin(), ring.shown.end(), 0) == ring.shown.end()) return;
  const Eigen::MatrixXf mean = mean_rows(ring);
  int first = 0;
  for (const int n : resolution) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const int sample = first + lattice_index(n, i, j);
        if (ring.shown[sample]) continue;
        Eigen::MatrixXf sum = Eigen::MatrixXf::Zero(3, ring.rank());
        int seen = 0;
        for (const auto& [di, dj] : kLatticeNeighbours) {
          const int a = i + di, b = j + dj;
          if (a < 0 || b < 0 || a + b >= n) continue;
          const int neighbour = first + lattice_index(n, a, b);
          if (!ring.shown[neighbour]) continue;
          sum += ring.basis.middleRows<3>(3 * neighbour);
          ++seen;
        }
        if (seen > 0)
          ring.basis.middleRows<3>(3 * sample) = sum / static_cast<float>(seen);
        else
          ring.basis.middleRows<3>(3 * sample) = mean;
      }
    first += lattice_samples(n);
  }
}

std::shared_ptr<const SurfaceLightFieldSnapshot> fill_unseen(const SurfaceLightFieldSnapshot& snapshot) {
  const Mesh& mesh = snapshot.mesh();
  std::vector<std::shared_ptr<const RingSnapshot>> rings = snapshot.ring_data();
  const auto has_colour = [&](std::uint32_t v) { return rings[v] && rings[v]->rank() > 0; };
  std::vector<std::uint32_t> seen, guessed;
  for (std::uint32_t v = 0; v < rings.size(); ++v)
    if (has_colour(v)) seen.push_back(v);

  std::deque<std::uint32_t> front(seen.begin(), seen.end());  // breadth first from what is known
  const auto guess = [&](std::uint32_t from, std::uint32_t to) {
    if (has_colour(to)) return;
    rings[to] = flat_copy(*rings[from], snapshot.rings().ring_samples(to));
    guessed.push_back(to);
    front.push_back(to);
  };
  const std::vector<std::uint32_t> same_place = next_at_place(mesh);
  const auto spread = [&] {
    for (; !front.empty(); front.pop_front()) {
      const std::uint32_t v = front.front();
      for (std::uint32_t next = same_place[v]; next != v; next = same_place[next]) guess(v, next);
      for (const RingTriangle& member : snapshot.rings().ring(v))
        for (const std::uint32_t next : mesh.triangles[member.triangle]) guess(v, next);
    }
  };
  spread();
  if (!seen.empty()) {
    const Eigen::Matrix3Xf places = places_of(mesh, seen);
    for (std::uint32_t v = 0; v < rings.size(); ++v) {  // parts of the mesh of which nothing was seen
      if (has_colour(v) || snapshot.rings().ring(v).empty()) continue;
      Eigen::Index nearest = 0;
      (places.colwise() - mesh.vertices[v]).colwise().squaredNorm().minCoeff(&nearest);
      guess(seen[static_cast<std::size_t>(nearest)], v);
      spread();
    }
  }

  for (const std::uint32_t v : guessed) {
    auto marked = std::make_shared<RingSnapshot>(*rings[v]);
    std::fill(marked->shown.begin(), marked->shown.end(), std::uint8_t{0});
    rings[v] = std::move(marked);
  }
  return std::make_shared<SurfaceLightFieldSnapshot>(snapshot.shared_mesh(), snapshot.shared_rings(), std::move(rings),
                                                     snapshot.version(), snapshot.exposure());
}

}  // namespace sheen
