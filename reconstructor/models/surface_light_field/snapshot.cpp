// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/snapshot.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "common/base/median.h"
#include "reconstructor/models/surface_light_field/compact/compress.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

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

bool RingSnapshot::seen() const {
  return rank() > 0 && directions.cols() > 0 &&
         std::any_of(shown.begin(), shown.end(), [](std::uint8_t share) { return share > 0; });
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
                                                     std::uint64_t version, ExposureField exposure,
                                                     std::vector<PosedCamera> cameras)
    : LightFieldSnapshot(std::move(mesh), std::move(rings), version, std::move(exposure), std::move(cameras)),
      ring_data_(std::move(ring_data)),
      common_sill_(mean_sill(ring_data_)) {}

PatchCorner SurfaceLightFieldSnapshot::corner(std::size_t triangle, int corner) const {
  const std::uint32_t vertex = mesh().triangles[triangle][static_cast<std::size_t>(corner)];
  return {vertex, rings().membership(triangle, corner).first_sample, vertex};
}

std::shared_ptr<const LightFieldSnapshot> SurfaceLightFieldSnapshot::with_patches(
    const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const {
  std::vector<std::shared_ptr<const RingSnapshot>> data;
  data.reserve(patches.size());
  for (const auto& patch : patches) data.push_back(std::static_pointer_cast<const RingSnapshot>(patch));
  return std::make_shared<SurfaceLightFieldSnapshot>(shared_mesh(), shared_rings(), std::move(data), version(),
                                                     exposure(), cameras());
}

const RingViews* SurfaceLightFieldSnapshot::seen_ring(std::size_t vertex) const {
  const RingSnapshot* ring = ring_data_[vertex].get();
  return ring && ring->seen() ? ring : nullptr;
}

double SurfaceLightFieldSnapshot::ring_variation(std::size_t vertex) const {
  const RingSnapshot& ring = *ring_data_[vertex];
  double sum = 0;
  for (Eigen::Index j = 0; j < ring.directions.cols(); ++j) {
    const Eigen::VectorXf h = ring.coefficients(ring.directions.col(j));
    const double unexplained = ring.residual * ring.residual * h.squaredNorm();
    sum += (h - ring.mean).squaredNorm() + unexplained;
  }
  return sum / (static_cast<double>(ring.basis.rows()) * static_cast<double>(ring.directions.cols()));
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
    samples += static_cast<std::size_t>(rings().ring_samples(v));
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
      const Eigen::Vector3f direction = (eye.cast<float>() - mesh().vertices[v]).normalized();
      coefficients.col(static_cast<Eigen::Index>(v)).head(ring->rank()) = ring->coefficients(direction);
    }
  });
  return coefficients;
}

std::shared_ptr<const ModelSnapshot> SurfaceLightFieldSnapshot::filled() const {
  return fill_unseen(*this);
}

std::size_t RingSnapshot::bytes() const {
  const Eigen::Index values =
      basis.size() + weights.size() + mean.size() + drift.size() + directions.size() + reliability.size();
  return static_cast<std::size_t>(values) * sizeof(float) + shown.size();
}

std::size_t SurfaceLightFieldSnapshot::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : ring_data_)
    if (ring) bytes += ring->bytes();
  return bytes;
}

CompressedModel SurfaceLightFieldSnapshot::compressed(const CompressionTarget& target) const {
  return compress(*this, target);
}

void SurfaceLightFieldSnapshot::save(const std::filesystem::path& folder, const ModelMetadata& metadata,
                                     const StepsDone& progress) const {
  save_model(*this, folder, metadata, {.progress = progress});
}

std::shared_ptr<const ModelSnapshot> bare_mesh(std::shared_ptr<const Mesh> mesh, std::vector<PosedCamera> cameras) {
  constexpr std::uint8_t kLeastResolution = 2;
  auto rings = std::make_shared<const VertexRings>(*mesh, std::vector(mesh->triangles.size(), kLeastResolution));
  std::vector<std::shared_ptr<const RingSnapshot>> unknown(mesh->vertices.size());
  return std::make_shared<SurfaceLightFieldSnapshot>(std::move(mesh), std::move(rings), std::move(unknown), 0,
                                                     ExposureField{}, std::move(cameras));
}

}  // namespace sheen
