// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/fill_unseen.h"

#include <algorithm>

#include "reconstructor/surface/nearest_seen.h"

namespace sheen {
namespace {

constexpr int kLatticeNeighbours[6][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, -1}, {-1, 1}};

/// Rows of the samples of a lattice, so many for each, from `first_row` on. `seen`: per sample. Those that were not are
/// given the mean of those beside them that were, farther off `mean`, per row of a sample.
void fill(Eigen::MatrixXf& basis, int first_row, int rows_each, int side, std::span<const std::uint8_t> seen,
          const Eigen::Ref<const Eigen::MatrixXf>& mean) {
  const auto rows_of = [&](int sample) { return basis.middleRows(first_row + rows_each * sample, rows_each); };
  for (int i = 0; i < side; ++i)
    for (int j = 0; i + j < side; ++j) {
      const int sample = lattice_index(side, i, j);
      if (seen[static_cast<std::size_t>(sample)]) continue;
      Eigen::MatrixXf sum = Eigen::MatrixXf::Zero(rows_each, basis.cols());
      int count = 0;
      for (const auto& [di, dj] : kLatticeNeighbours) {
        const int a = i + di, b = j + dj;
        if (a < 0 || b < 0 || a + b >= side) continue;
        const int neighbour = lattice_index(side, a, b);
        if (!seen[static_cast<std::size_t>(neighbour)]) continue;
        sum += rows_of(neighbour);
        ++count;
      }
      if (count > 0)
        rows_of(sample) = sum / static_cast<float>(count);
      else
        rows_of(sample) = mean;
    }
}

}  // namespace

void fill_unseen_samples(SurfacePatch& patch, std::span<const int> resolution) {
  if (patch.rank() == 0 || std::find(patch.shown.begin(), patch.shown.end(), 0) == patch.shown.end()) return;
  const Eigen::MatrixXf mean = patch.mean_seen_colours();
  Eigen::MatrixXf basis = patch.basis.unpacked();
  if (patch.planes) {
    const ColourPlanes& planes = *patch.planes;
    const Eigen::MatrixXf mean_of = opponent_colours() * mean;
    const std::vector<std::uint8_t> known = planes.guessed_places(patch.shown);
    for (const ColourPlanes::Triangle& triangle : planes.triangles()) {
      const auto first = static_cast<std::size_t>(triangle.first_sample);
      fill(basis, triangle.first_sample, 1, triangle.side, std::span(known).subspan(first), mean_of.row(0));
      const int first_chroma = planes.samples() + triangle.first_chroma;
      const auto chroma_known = std::span(known).subspan(static_cast<std::size_t>(first_chroma));
      fill(basis, first_chroma, 1, triangle.chroma_side, chroma_known, triangle.chroma_weight * mean_of.row(1));
      fill(basis, first_chroma + planes.chroma_samples(), 1, triangle.chroma_side, chroma_known,
           triangle.chroma_weight * mean_of.row(2));
    }
  } else {
    int first = 0;
    for (const int side : resolution) {
      fill(basis, 3 * first, 3, side, std::span(patch.shown).subspan(static_cast<std::size_t>(first)), mean);
      first += lattice_samples(side);
    }
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
    const Eigen::MatrixXf mean = source.patch->mean_seen_colours();
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
  return std::make_shared<SurfaceLightFieldSnapshot>(
      snapshot.shared_mesh(), snapshot.shared_maps(), snapshot.shared_shapes(), std::move(patches), snapshot.version(),
      snapshot.exposure(), snapshot.cameras(), snapshot.guidance_method());
}

}  // namespace sheen
