// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/snapshot.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "common/base/median.h"
#include "common/image/color.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/models/surface_light_field/next_view.h"
#include "reconstructor/models/surface_light_field/quality.h"

namespace sheen {
namespace {

/// Shades from the basis maps and one vector of view coefficients a vertex.
class LightFieldShader : public ViewShader {
 public:
  LightFieldShader(const SurfaceLightFieldSnapshot& snapshot, const Eigen::Vector3d& eye)
      : mesh_(snapshot.shared_mesh()),
        rings_(snapshot.shared_rings()),
        ring_data_(snapshot.ring_data()),
        coefficients_(snapshot.coefficients_for(eye)),
        exposure_(snapshot.exposure().at(eye)),
        quality_(snapshot.quality_for(eye)) {}

  SurfaceSample shade(std::uint32_t triangle, float u, float v) const override {
    const float beta[3] = {1 - u - v, u, v};
    const LatticeStencil stencil = lattice_stencil(rings_->resolution(triangle), u, v);
    Eigen::Vector3f encoded = Eigen::Vector3f::Zero();
    float total = 0;
    SampleState state = SampleState::kUnseen;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t vertex = mesh_->triangles[triangle][c];
      const RingSnapshot* ring = ring_data_[vertex].get();
      if (!ring || ring->rank() == 0) continue;
      const std::uint32_t first = rings_->membership(triangle, c).first_sample;
      const auto h = coefficients_.col(vertex).head(ring->rank());
      Eigen::Vector3f value = Eigen::Vector3f::Zero();
      for (int k = 0; k < 3; ++k) {
        const int sample = static_cast<int>(first) + stencil.index[k];
        value.noalias() += stencil.weight[k] * (ring->basis.middleRows<3>(3 * sample) * h);
        if (stencil.weight[k] > 0.25f) state = std::max(state, ring->state(sample));
      }
      encoded += beta[c] * value;
      total += beta[c];
    }
    if (total < 1e-4f) return {};
    encoded /= total;
    const Eigen::Vector3f radiance(srgb_decode(encoded.x()), srgb_decode(encoded.y()), srgb_decode(encoded.z()));
    return {exposure_ * radiance, state};
  }
  SurfaceQuality quality(std::uint32_t triangle) const override { return quality_[triangle]; }

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const VertexRings> rings_;
  std::vector<std::shared_ptr<const RingSnapshot>> ring_data_;
  Eigen::MatrixXf coefficients_;
  float exposure_;
  std::vector<SurfaceQuality> quality_;
};

/// Over the images of all rings; before any image two of them is a guess.
float mean_sill(const std::vector<std::shared_ptr<const RingSnapshot>>& rings) {
  constexpr double kGuess = 0.02;  // what no other image confirms may be anything: a heuristic near 1
  double sum = kGuess, views = 1;
  for (const auto& ring : rings) {
    if (!ring || ring->directions.cols() < 2) continue;
    sum += ring->sill * static_cast<double>(ring->directions.cols());
    views += static_cast<double>(ring->directions.cols());
  }
  return static_cast<float>(sum / views);
}

}  // namespace

std::uint8_t shown_share(int showed_it, int images) {
  if (showed_it <= 0) return 0;
  return static_cast<std::uint8_t>(std::clamp(std::lround(255.0 * showed_it / std::max(images, 1)), 1L, 255L));
}

SampleState sample_state(std::uint8_t shown) {
  constexpr int kHalf = 128;
  if (shown == 0) return SampleState::kUnseen;
  return shown < kHalf ? SampleState::kImputed : SampleState::kMeasured;
}

void RingSnapshot::set_interpolation(ViewInterpolant interpolant, const ViewKernel& view_kernel,
                                     std::shared_ptr<const ReflectionDrift> shared) {
  kernel = view_kernel;
  mean = std::move(interpolant.mean);
  weights = std::move(interpolant.weights);
  drift = std::move(interpolant.drift);
  if (drift.size() > 0) reflection = std::move(shared);
  const auto samples = std::count_if(shown.begin(), shown.end(), [](std::uint8_t share) { return share > 0; });
  const double values = 3.0 * static_cast<double>(std::max<std::ptrdiff_t>(samples, 1));
  constexpr double kMostSill = 1e6;  // of images without bounds: what files hold, and as bad as can be
  sill = static_cast<float>(std::min(interpolant.sill / values, kMostSill));
}

void RingSnapshot::set_triangulation(const Eigen::MatrixXf& coefficients) {
  triangulation = std::make_shared<ViewTriangulation>(triangulate_views(frame, directions));
  weights = coefficients;
  mean.setZero();
  drift.resize(0);
  reflection.reset();
}

Eigen::VectorXf RingSnapshot::coefficients(const Eigen::Vector3f& direction) const {
  if (triangulation) return weights * delaunay_weights(*triangulation, hemisphere_point(frame, direction));
  Eigen::VectorXf h = mean + weights * covariances(kernel, directions, direction);
  if (reflection) h += reflection->at(direction, frame.row(2)) * drift;
  return h;
}

SurfaceLightFieldSnapshot::SurfaceLightFieldSnapshot(std::shared_ptr<const Mesh> mesh,
                                                     std::shared_ptr<const VertexRings> rings,
                                                     std::vector<std::shared_ptr<const RingSnapshot>> ring_data,
                                                     std::uint64_t version, ExposureField exposure)
    : mesh_(std::move(mesh)),
      rings_(std::move(rings)),
      ring_data_(std::move(ring_data)),
      version_(version),
      exposure_(std::move(exposure)),
      common_sill_(mean_sill(ring_data_)) {}

std::unique_ptr<ViewShader> SurfaceLightFieldSnapshot::shader_for(const ViewQuery& query) const {
  return std::make_unique<LightFieldShader>(*this, query.eye);
}

int SurfaceLightFieldSnapshot::max_rank() const {
  int rank = 0;
  for (const auto& ring : ring_data_)
    if (ring) rank = std::max(rank, ring->rank());
  return rank;
}

SnapshotFigures SurfaceLightFieldSnapshot::figures() const {
  SnapshotFigures figures;
  std::vector<int> ranks;
  std::size_t seen = 0, measured = 0, samples = 0;
  for (std::size_t v = 0; v < ring_data_.size(); ++v) {
    const RingSnapshot* ring = ring_data_[v].get();
    samples += static_cast<std::size_t>(rings_->ring_samples(v));
    if (!ring) continue;
    std::size_t here = 0;
    for (const std::uint8_t shown : ring->shown) {
      here += sample_state(shown) != SampleState::kUnseen;
      measured += sample_state(shown) == SampleState::kMeasured;
    }
    seen += here;
    if (here > 0) ranks.push_back(ring->rank());
  }
  if (samples > 0) {
    figures.seen = static_cast<double>(seen) / static_cast<double>(samples);
    figures.measured = static_cast<double>(measured) / static_cast<double>(samples);
  }
  if (ranks.empty()) return figures;
  figures.median_rank = median(ranks);
  const auto middle = ranks.begin() + static_cast<std::ptrdiff_t>(ranks.size() / 2);
  if (ranks.size() % 2 == 0)
    figures.median_rank = 0.5 * (figures.median_rank + *std::max_element(ranks.begin(), middle));
  figures.most_rank = *std::max_element(ranks.begin(), ranks.end());
  return figures;
}

Eigen::MatrixXf SurfaceLightFieldSnapshot::coefficients_for(const Eigen::Vector3d& eye) const {
  Eigen::MatrixXf coefficients = Eigen::MatrixXf::Zero(max_rank(), static_cast<Eigen::Index>(ring_data_.size()));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, ring_data_.size(), 64), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      const RingSnapshot* ring = ring_data_[v].get();
      if (!ring || ring->rank() == 0) continue;
      const Eigen::Vector3f direction = (eye.cast<float>() - mesh_->vertices[v]).normalized();
      coefficients.col(static_cast<Eigen::Index>(v)).head(ring->rank()) = ring->coefficients(direction);
    }
  });
  return coefficients;
}

std::vector<SurfaceQuality> SurfaceLightFieldSnapshot::quality_for(const Eigen::Vector3d& eye) const {
  std::vector<SurfaceQuality> rings(ring_data_.size()), triangles;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rings.size(), 64), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (ring_data_[v])
        rings[v] = assess_ring(*ring_data_[v], (eye.cast<float>() - mesh_->vertices[v]).normalized(), common_sill_);
  });
  triangles.reserve(mesh_->triangles.size());
  for (const auto& [a, b, c] : mesh_->triangles) triangles.push_back(combine(rings[a], rings[b], rings[c]));
  return triangles;
}

std::shared_ptr<const ModelSnapshot> SurfaceLightFieldSnapshot::filled() const {
  return fill_unseen(*this);
}

ViewAdvice SurfaceLightFieldSnapshot::advise_next_view(const Eigen::Vector3d& eye) const {
  return sheen::advise_next_view(*this, eye);
}

void SurfaceLightFieldSnapshot::save(const std::filesystem::path& folder, const ModelMetadata& metadata,
                                     const StepsDone& progress) const {
  save_model(*this, folder, metadata, {.progress = progress});
}

}  // namespace sheen
