// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/fill_unseen.h"

#include <algorithm>

#include "reconstructor/surface/nearest_seen.h"

namespace sheen {
namespace {

constexpr int kLatticeNeighbours[6][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};

}  // namespace

Eigen::MatrixXf mean_seen_rows(const SurfacePatch& patch) {
  const Eigen::MatrixXf basis = patch.basis.unpacked();
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, patch.rank());
  int seen = 0;
  for (std::size_t s = 0; s < patch.shown.size(); ++s)
    if (patch.shown[s]) {
      mean += basis.middleRows<3>(static_cast<Eigen::Index>(3 * s));
      ++seen;
    }
  return mean / static_cast<float>(std::max(seen, 1));
}

void fill_unseen_samples(SurfacePatch& patch, std::span<const int> resolution) {
  if (patch.rank() == 0 || std::find(patch.shown.begin(), patch.shown.end(), 0) == patch.shown.end()) return;
  const Eigen::MatrixXf mean = mean_seen_rows(patch);
  Eigen::MatrixXf basis = patch.basis.unpacked();
  int first = 0;
  for (const int n : resolution) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const int sample = first + lattice_index(n, i, j);
        if (patch.shown[sample]) continue;
        Eigen::MatrixXf sum = Eigen::MatrixXf::Zero(3, patch.rank());
        int seen = 0;
        for (const auto& [di, dj] : kLatticeNeighbours) {
          const int a = i + di, b = j + dj;
          if (a < 0 || b < 0 || a + b >= n) continue;
          const int neighbour = first + lattice_index(n, a, b);
          if (!patch.shown[neighbour]) continue;
          sum += basis.middleRows<3>(3 * neighbour);
          ++seen;
        }
        if (seen > 0)
          basis.middleRows<3>(3 * sample) = sum / static_cast<float>(seen);
        else
          basis.middleRows<3>(3 * sample) = mean;
      }
    first += lattice_samples(n);
  }
  patch.basis = patch.basis.alike(std::move(basis));
}

namespace {

/// The patch and the vertex of it from which a guess is taken.
struct Source {
  const PatchSnapshot* patch = nullptr;
  const VertexInterpolant* at = nullptr;
};

Source source_at(const SurfaceLightFieldSnapshot& snapshot, std::uint32_t vertex) {
  const VertexInterpolant* const at = snapshot.seen_at(vertex);
  for (const PatchVertex& round : snapshot.shapes().round(vertex)) {
    const PatchSnapshot* patch = snapshot.patches()[round.patch].get();
    if (patch && &patch->vertices[round.vertex] == at) return {patch, at};
  }
  return {};
}

/// A patch of unseen samples that has everywhere the mean colours of what lies nearest to its vertices: a term for each
/// channel.
std::shared_ptr<const PatchSnapshot> guess(const SurfaceLightFieldSnapshot& snapshot, const PatchShape& shape,
                                           std::span<const std::uint32_t> nearest) {
  auto guess = std::make_shared<PatchSnapshot>();
  guess->basis = Eigen::MatrixXf(Eigen::Matrix3f::Identity().replicate(shape.samples, 1));
  guess->shown.assign(shape.samples, 0);
  for (const std::uint32_t v : shape.vertices) {
    if (nearest[v] == kNoVertex) return nullptr;
    const Source source = source_at(snapshot, nearest[v]);
    const Eigen::MatrixXf mean = mean_seen_rows(*source.patch);
    VertexInterpolant& at = guess->vertices.emplace_back(*source.at);
    at.weights = at.weights.alike(at.weights.unpacked() * mean.transpose());
    at.mean = mean * at.mean;
    if (at.drift.size() > 0) at.drift = mean * at.drift;
  }
  return guess;
}

}  // namespace

std::shared_ptr<const SurfaceLightFieldSnapshot> fill_unseen(const SurfaceLightFieldSnapshot& snapshot) {
  SurfaceLightFieldSnapshot::Patches patches = snapshot.patches();
  std::vector<std::uint8_t> seen(snapshot.mesh().vertices.size());
  for (std::size_t v = 0; v < seen.size(); ++v) seen[v] = snapshot.seen_at(v) != nullptr;
  const std::vector<std::uint32_t> nearest = nearest_seen(snapshot.mesh(), seen);
  for (std::size_t p = 0; p < patches.size(); ++p)
    if (!patches[p] || !patches[p]->seen()) patches[p] = guess(snapshot, snapshot.shapes().patches[p], nearest);
  return std::make_shared<SurfaceLightFieldSnapshot>(snapshot.shared_mesh(), snapshot.shared_maps(),
                                                     snapshot.shared_shapes(), std::move(patches), snapshot.version(),
                                                     snapshot.exposure(), snapshot.cameras());
}

}  // namespace sheen
