// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/snapshot.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "common/base/order_statistics.h"
#include "reconstructor/models/surface_light_field/compact/compress.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

/// Over the images of all patches; before any image two of them is a guess.
float mean_sill(const SurfaceLightFieldSnapshot::Patches& patches) {
  constexpr double kGuess = 0.02;  // what no other image confirms may be anything: a heuristic near 1
  double sum = kGuess, views = 1;
  for (const auto& patch : patches) {
    if (!patch) continue;
    for (const VertexInterpolant& vertex : patch->vertices) {
      const Eigen::Index count = vertex.views->directions.cols();
      if (count < 2) continue;
      sum += vertex.sill * static_cast<double>(count);
      views += static_cast<double>(count);
    }
  }
  return static_cast<float>(sum / views);
}

}  // namespace

SurfaceLightFieldSnapshot::SurfaceLightFieldSnapshot(std::shared_ptr<const Mesh> mesh,
                                                     std::shared_ptr<const MapLayout> maps,
                                                     std::shared_ptr<const PatchShapes> shapes, Patches patches,
                                                     std::uint64_t version, ExposureField exposure,
                                                     std::vector<PosedCamera> cameras, GuidanceMethod guidance)
    : LightFieldSnapshot(std::move(mesh), std::move(maps), version, std::move(exposure), std::move(cameras), guidance),
      shapes_(std::move(shapes)),
      patches_(std::move(patches)),
      common_sill_(mean_sill(patches_)) {}

bool SurfaceLightFieldSnapshot::seen(std::size_t triangle) const {
  const PatchSnapshot* patch = patches_[shapes_->patch_of[triangle]].get();
  return patch && patch->seen();
}

TrianglePlace SurfaceLightFieldSnapshot::place(std::size_t triangle) const {
  return shapes_->place(triangle);
}

std::shared_ptr<const LightFieldSnapshot> SurfaceLightFieldSnapshot::with_patches(
    const std::vector<std::shared_ptr<const SurfacePatch>>& patches) const {
  Patches data;
  data.reserve(patches.size());
  for (const auto& patch : patches) data.push_back(std::static_pointer_cast<const PatchSnapshot>(patch));
  return std::make_shared<SurfaceLightFieldSnapshot>(shared_mesh(), shared_maps(), shapes_, std::move(data), version(),
                                                     exposure(), cameras(), guidance_method());
}

const VertexInterpolant* SurfaceLightFieldSnapshot::seen_at(std::size_t vertex) const {
  const VertexInterpolant* most = nullptr;
  for (const PatchVertex& round : shapes_->round(vertex)) {
    const PatchSnapshot* patch = patches_[round.patch].get();
    if (!patch || !patch->seen()) continue;
    const VertexInterpolant& here = patch->vertices[round.vertex];
    if (!most || here.views->directions.cols() > most->views->directions.cols()) most = &here;
  }
  return most;
}

double SurfaceLightFieldSnapshot::vertex_variation(std::size_t vertex) const {
  const PatchSnapshot* patch = nullptr;
  const VertexInterpolant* const at = seen_at(vertex);
  for (const PatchVertex& round : shapes_->round(vertex))
    if (patches_[round.patch] && &patches_[round.patch]->vertices[round.vertex] == at)
      patch = patches_[round.patch].get();
  const Eigen::Matrix3Xf& directions = at->views->directions;
  double sum = 0;
  for (Eigen::Index j = 0; j < directions.cols(); ++j) {
    const Eigen::VectorXf h = at->coefficients(directions.col(j));
    const double unexplained = at->residual * at->residual * h.squaredNorm();
    sum += (h - at->mean).squaredNorm() + unexplained;
  }
  const double values = 3 * static_cast<double>(patch->shown.size());
  return sum / (values * static_cast<double>(directions.cols()));
}

int SurfaceLightFieldSnapshot::max_rank() const {
  int rank = 0;
  for (const auto& patch : patches_)
    if (patch) rank = std::max(rank, patch->rank());
  return rank;
}

SnapshotFigures SurfaceLightFieldSnapshot::figures() const {
  SnapshotFigures figures;
  std::vector<int> ranks;
  std::size_t seen = 0, measured = 0, samples = 0;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    samples += shapes_->patches[p].samples;
    if (!patches_[p]) continue;
    std::size_t here = 0;
    for (const std::uint8_t shown : patches_[p]->shown) {
      here += sample_state(shown) != SampleState::kUnseen;
      measured += sample_state(shown) == SampleState::kMeasured;
    }
    seen += here;
    if (here > 0) ranks.push_back(patches_[p]->rank());
  }
  if (samples > 0) {
    figures.seen = static_cast<double>(seen) / static_cast<double>(samples);
    figures.measured = static_cast<double>(measured) / static_cast<double>(samples);
  }
  if (ranks.empty()) return figures;
  figures.median_rank = median_of_both_middles<double>(ranks);
  figures.most_rank = *std::max_element(ranks.begin(), ranks.end());
  return figures;
}

Eigen::MatrixXf SurfaceLightFieldSnapshot::coefficients_for(const Eigen::Vector3d& eye) const {
  return coefficients_for(eye, std::vector<bool>(patches_.size(), true));
}

Eigen::MatrixXf SurfaceLightFieldSnapshot::coefficients_for(const Eigen::Vector3d& eye,
                                                            const std::vector<bool>& wanted) const {
  Eigen::MatrixXf coefficients = Eigen::MatrixXf::Zero(max_rank(), static_cast<Eigen::Index>(shapes_->columns()));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh().vertices.size(), 16), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      CoefficientsAtVertex from_here((eye.cast<float>() - mesh().vertices[v]).normalized());
      for (const auto& [p, i] : shapes_->round(v)) {
        const PatchSnapshot* patch = patches_[p].get();
        if (!wanted[p] || !patch || patch->rank() == 0) continue;
        from_here.of(patch->vertices[i],
                     coefficients.col(static_cast<Eigen::Index>(shapes_->first_column[p] + i)).head(patch->rank()));
      }
    }
  });
  return coefficients;
}

Eigen::MatrixXf SurfaceLightFieldSnapshot::average_coefficients() const {
  Eigen::MatrixXf average = Eigen::MatrixXf::Zero(max_rank(), static_cast<Eigen::Index>(shapes_->columns()));
  tbb::parallel_for(std::size_t{0}, patches_.size(), [&](std::size_t p) {
    const PatchSnapshot* patch = patches_[p].get();
    if (!patch || patch->rank() == 0) return;
    auto column = static_cast<Eigen::Index>(shapes_->first_column[p]);
    for (const VertexInterpolant& vertex : patch->vertices)
      average.col(column++).head(patch->rank()) = vertex.average_coefficients();
  });
  return average;
}

std::shared_ptr<const ModelSnapshot> SurfaceLightFieldSnapshot::filled() const {
  return fill_unseen(*this);
}

std::size_t SurfaceLightFieldSnapshot::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& patch : patches_)
    if (patch) bytes += patch->bytes();
  for (std::size_t v = 0; v < mesh().vertices.size(); ++v) {
    std::vector<const VertexViews*> counted;  // those that patches share
    for (const auto& [p, i] : shapes_->round(v)) {
      const VertexViews* views = patches_[p] ? patches_[p]->vertices[i].views.get() : nullptr;
      if (!views || std::find(counted.begin(), counted.end(), views) != counted.end()) continue;
      counted.push_back(views);
      bytes += views->bytes();
    }
  }
  return bytes;
}

bool SurfaceLightFieldSnapshot::triangulated() const {
  return std::any_of(patches_.begin(), patches_.end(), [](const auto& patch) {
    return patch && !patch->vertices.empty() && patch->vertices.front().triangulation;
  });
}

std::unique_ptr<Compression> SurfaceLightFieldSnapshot::compression(CompressionTarget target) const {
  return compress(*this, std::move(target));
}

void SurfaceLightFieldSnapshot::save(const std::filesystem::path& folder, const ModelMetadata& metadata,
                                     const StepsDone& progress) const {
  save_model(*this, folder, metadata, {.progress = progress});
}

std::shared_ptr<const ModelSnapshot> bare_mesh(std::shared_ptr<const Mesh> mesh, std::vector<PosedCamera> cameras) {
  constexpr std::uint8_t kLeastResolution = 2;
  auto maps = std::make_shared<const MapLayout>(std::vector(mesh->triangles.size(), kLeastResolution));
  auto shapes = std::make_shared<const PatchShapes>(cut_into_patches(*mesh, *maps, {.triangles = 1}));
  SurfaceLightFieldSnapshot::Patches unknown(shapes->patches.size());
  return std::make_shared<SurfaceLightFieldSnapshot>(std::move(mesh), std::move(maps), std::move(shapes),
                                                     std::move(unknown), 0, ExposureField{}, std::move(cameras));
}

}  // namespace sheen
