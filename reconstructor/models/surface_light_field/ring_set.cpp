// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace sheen {
namespace {

/// Place of a vertex on a Z-order curve through the mesh's bounds.
std::uint64_t z_order(const Eigen::Vector3f& place, const Eigen::Vector3f& lowest, float size) {
  constexpr int kBits = 20;  // per axis
  std::uint64_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float share = size > 0 ? (place[axis] - lowest[axis]) / size : 0;
    const auto cell = static_cast<std::uint64_t>(share * ((1 << kBits) - 1));
    for (int bit = 0; bit < kBits; ++bit) code |= (cell >> bit & 1) << (3 * bit + axis);
  }
  return code;
}

/// Rings that lie together fold together, for they hold the same rows until they do: as many as leave enough groups for
/// the work to be spread evenly over images.
std::vector<unsigned> phases_of(const Mesh& mesh) {
  constexpr std::size_t kMostTogether = 64, kFewestGroups = 80;
  std::vector<unsigned> phases(mesh.vertices.size());
  std::iota(phases.begin(), phases.end(), 0u);
  const std::size_t together = std::min(mesh.vertices.size() / kFewestGroups, kMostTogether);
  if (together <= 1) return phases;
  const Eigen::Map<const Eigen::Matrix3Xf> places(mesh.vertices.front().data(), 3,
                                                  static_cast<Eigen::Index>(mesh.vertices.size()));
  const Eigen::Vector3f lowest = places.rowwise().minCoeff();
  const float size = (places.rowwise().maxCoeff() - lowest).maxCoeff();
  std::vector<std::pair<std::uint64_t, std::uint32_t>> along;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    along.emplace_back(z_order(mesh.vertices[v], lowest, size), v);
  std::sort(along.begin(), along.end());
  for (std::size_t i = 0; i < along.size(); ++i) phases[along[i].second] = static_cast<unsigned>(i / together);
  return phases;
}

}  // namespace

RingSet::RingSet(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const VertexRings> rings,
                 std::span<const Eigen::Matrix3f> frames, const RingModelOptions& options)
    : mesh_(std::move(mesh)),
      rings_(std::move(rings)),
      frames_(frames),
      options_(options),
      phases_(phases_of(*mesh_)),
      models_(mesh_->vertices.size()) {}

bool RingSet::gather(std::size_t ring, const ShownImage& image, RingColumn& column) const {
  return sheen::gather(*rings_, ring, mesh_->vertices[ring], image.view, image.samples, column);
}

std::vector<std::uint32_t> RingSet::shown_by(const SurfaceView& view) const {
  std::vector<std::uint32_t> shown;
  for (std::size_t v = 0; v < rings_->size(); ++v) {
    const auto ring = rings_->ring(v);
    if (std::any_of(ring.begin(), ring.end(),
                    [&](const RingTriangle& member) { return view.visible_in_triangle[member.triangle] > 0; }))
      shown.push_back(static_cast<std::uint32_t>(v));
  }
  return shown;
}

std::vector<std::uint32_t> RingSet::newest(Indices shown, const SurfaceView& view, std::size_t wanted) const {
  std::vector<std::pair<float, std::uint32_t>> by_novelty(shown.size());
  tbb::parallel_for(std::size_t{0}, shown.size(), [&](std::size_t i) {
    const std::uint32_t v = shown[i];
    const Eigen::Vector3f direction = (view.eye.cast<float>() - mesh_->vertices[v]).normalized();
    by_novelty[i] = {models_[v] ? models_[v]->nearest_cosine(direction) : -2.0f, v};
  });
  std::nth_element(by_novelty.begin(), by_novelty.begin() + static_cast<std::ptrdiff_t>(wanted), by_novelty.end());
  std::vector<std::uint32_t> newest(wanted);
  for (std::size_t i = 0; i < wanted; ++i) newest[i] = by_novelty[i].second;
  std::sort(newest.begin(), newest.end());
  return newest;
}

std::size_t RingSet::count_repeated(Indices tested, const ShownImage& image) const {
  RingColumn column;
  const auto repeated = std::count_if(tested.begin(), tested.end(), [&](std::uint32_t v) {
    return models_[v] && gather(v, image, column) &&
           models_[v]->repeats(column.values, column.visible, column.direction);
  });
  return static_cast<std::size_t>(repeated);
}

RingModel::Prediction RingSet::predict(Indices asked, const ShownImage& image) const {
  std::vector<RingModel::Prediction> predicted(asked.size());
  tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t i) {
    const std::uint32_t v = asked[i];
    RingColumn column;
    if (gather(v, image, column))
      predicted[i] = models_[v]->predict(column.values, column.visible, column.direction, frames_[v].row(2));
  });
  RingModel::Prediction all;
  for (const RingModel::Prediction& ring : predicted) {
    all.squared_error += ring.squared_error;
    all.values += ring.values;
  }
  return all;
}

RingSet::Update RingSet::absorb(Indices chosen, const ShownImage& image) {
  Update update;
  update.repeated.assign(chosen.size(), 0);
  std::vector<RingModel::Absorbed> absorbed(chosen.size());
  const TriangleRuns triangles = triangle_runs(*rings_, image.view, image.samples);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chosen.size(), 16), [&](const auto& range) {
    RingColumn column;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint32_t v = chosen[i];
      std::unique_ptr<RingModel>& ring = models_[v];
      if (!ring) ring = std::make_unique<RingModel>(rings_->ring_samples(v), options_, phases_[v]);
      look_at(*rings_, v, mesh_->vertices[v], image.view, column);
      if (ring->may_repeat(column.direction)) {
        gather(v, image, column);
        update.repeated[i] = ring->repeats(column.values, column.visible, column.direction);
      }
      if (!update.repeated[i])
        absorbed[i] = ring->absorb(runs_of(*rings_, v, triangles), column.visible, column.direction, column.cosine,
                                   column.cosine);
    }
  });
  const auto repeated = static_cast<std::size_t>(std::count(update.repeated.begin(), update.repeated.end(), 1));
  if (2 * repeated > chosen.size())
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chosen.size(), 16), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        if (absorbed[i].used) models_[chosen[i]]->fold_pending();
    });
  for (std::size_t i = 0; i < absorbed.size(); ++i) {
    if (!absorbed[i].used) continue;
    ++update.updated;
    update.energy += absorbed[i].energy;
    update.residual_energy += absorbed[i].residual_energy;
    if (absorbed[i].wants_interpolation) update.undecided.push_back(chosen[i]);
  }
  return update;
}

void RingSet::withdraw(const ShownImage& image, const std::vector<bool>& taken) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, models_.size(), 32), [&](const auto& range) {
    RingColumn column;
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if ((taken.empty() ? models_[v] != nullptr : taken[v]) && gather(v, image, column))
        models_[v]->withdraw(column.values, column.visible, column.direction);
  });
}

void RingSet::limit_terms(int max_rank, int internal_rank, int block) {
  options_.factor = options_.factor.limited_to(max_rank, internal_rank, block);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, models_.size(), 32), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (models_[v]) models_[v]->limit_terms(max_rank, internal_rank, block);
  });
}

std::shared_ptr<const RingSnapshot> RingSet::snapshot(std::size_t ring) {
  if (!models_[ring]) return nullptr;
  std::vector<int> resolution;
  for (const RingTriangle& member : rings_->ring(ring)) resolution.push_back(rings_->resolution(member.triangle));
  return models_[ring]->snapshot(frames_[ring], resolution);
}

std::vector<std::shared_ptr<const RingSnapshot>> RingSet::snapshots() {
  std::vector<std::shared_ptr<const RingSnapshot>> snapshots(models_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, snapshots.size(), 32), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) snapshots[v] = snapshot(v);
  });
  return snapshots;
}

std::vector<std::shared_ptr<const RingSnapshot>> RingSet::finish() {
  std::vector<std::shared_ptr<const RingSnapshot>> snapshots(models_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, snapshots.size(), 32), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      snapshots[v] = snapshot(v);
      models_[v].reset();
    }
  });
  return snapshots;
}

std::size_t RingSet::bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : models_)
    if (ring) bytes += ring->bytes();
  return bytes;
}

std::size_t RingSet::snapshot_bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : models_)
    if (ring) bytes += ring->snapshot_bytes();
  return bytes;
}

std::vector<std::size_t> RingSet::rank_histogram() const {
  std::vector<std::size_t> histogram;
  for (const auto& ring : models_) {
    if (!ring || ring->views() == 0) continue;
    const auto rank = static_cast<std::size_t>(ring->rank());
    if (histogram.size() <= rank) histogram.resize(rank + 1, 0);
    ++histogram[rank];
  }
  return histogram;
}

}  // namespace sheen
