// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/fill_unseen.h"

#include <algorithm>

#include "reconstructor/surface/nearest_seen.h"

namespace sheen {
namespace {

constexpr int kLatticeNeighbours[6][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};

/// A ring of `samples` unseen samples that has the seen ring's mean colour everywhere.
std::shared_ptr<const RingSnapshot> guess_from(const RingSnapshot& seen, int samples) {
  auto guess = std::make_shared<RingSnapshot>(seen);
  guess->basis = mean_seen_rows(seen).replicate(samples, 1);
  guess->shown.assign(static_cast<std::size_t>(samples), 0);
  return guess;
}

}  // namespace

Eigen::MatrixXf mean_seen_rows(const RingSnapshot& ring) {
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, ring.rank());
  int seen = 0;
  for (std::size_t s = 0; s < ring.shown.size(); ++s)
    if (ring.shown[s]) {
      mean += ring.basis.middleRows<3>(static_cast<Eigen::Index>(3 * s));
      ++seen;
    }
  return mean / static_cast<float>(std::max(seen, 1));
}

void fill_unseen_samples(RingSnapshot& ring, std::span<const int> resolution) {
  if (ring.rank() == 0 || std::find(ring.shown.begin(), ring.shown.end(), 0) == ring.shown.end()) return;
  const Eigen::MatrixXf mean = mean_seen_rows(ring);
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
  std::vector<std::shared_ptr<const RingSnapshot>> rings = snapshot.ring_data();
  std::vector<std::uint8_t> seen(rings.size());
  for (std::size_t v = 0; v < rings.size(); ++v) seen[v] = rings[v] && rings[v]->rank() > 0;
  const std::vector<std::uint32_t> source = nearest_seen(snapshot.mesh(), snapshot.rings(), seen);
  for (std::size_t v = 0; v < rings.size(); ++v)
    if (!seen[v] && source[v] != kNoVertex) rings[v] = guess_from(*rings[source[v]], snapshot.rings().ring_samples(v));
  return std::make_shared<SurfaceLightFieldSnapshot>(snapshot.shared_mesh(), snapshot.shared_rings(), std::move(rings),
                                                     snapshot.version(), snapshot.exposure(), snapshot.cameras());
}

}  // namespace sheen
