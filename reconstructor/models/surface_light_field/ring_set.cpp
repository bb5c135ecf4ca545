// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_set.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace sheen {

RingSet::RingSet(std::shared_ptr<const Mesh> mesh, std::shared_ptr<const VertexRings> rings,
                 std::span<const Eigen::Matrix3f> frames, const RingModelOptions& options)
    : mesh_(std::move(mesh)),
      rings_(std::move(rings)),
      frames_(frames),
      options_(options),
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
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, chosen.size(), 16), [&](const auto& range) {
    RingColumn column;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint32_t v = chosen[i];
      gather(v, image, column);
      std::unique_ptr<RingModel>& ring = models_[v];
      if (!ring) ring = std::make_unique<RingModel>(rings_->ring_samples(v), options_, v);
      update.repeated[i] = ring->repeats(column.values, column.visible, column.direction);
      if (!update.repeated[i])
        absorbed[i] = ring->absorb(column.values, column.visible, column.direction, column.cosine, column.cosine);
    }
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

std::vector<std::shared_ptr<const RingSnapshot>> RingSet::snapshots() {
  std::vector<std::shared_ptr<const RingSnapshot>> snapshots(models_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, snapshots.size(), 32), [&](const auto& range) {
    std::vector<int> resolution;
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      if (!models_[v]) continue;
      resolution.clear();
      for (const RingTriangle& member : rings_->ring(v)) resolution.push_back(rings_->resolution(member.triangle));
      snapshots[v] = models_[v]->snapshot(frames_[v], resolution);
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
