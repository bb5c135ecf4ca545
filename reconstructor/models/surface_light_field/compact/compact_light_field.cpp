// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/order_statistics.h"
#include "reconstructor/light_field_file/file_layout.h"
#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

constexpr std::uint64_t kOnlySnapshot = 1;  ///< number of a model that does not change
constexpr float kGreyLevels = 255;

/// A fraction of the patch's images that stands for the state.
std::uint8_t fraction_of(SampleState state) {
  constexpr std::uint8_t kFractions[] = {0, 64, 255};
  return kFractions[static_cast<std::size_t>(state)];
}

/// Of the patch, whose maps are let go of.
std::shared_ptr<const SurfacePatch> take_surface(Patch& patch) {
  if (patch.mean.size() == 0) return nullptr;
  auto surface = std::make_shared<SurfacePatch>();
  Eigen::MatrixXf basis(patch.mean.size(), 1 + patch.basis.cols());
  basis << patch.mean / kGreyLevels, patch.basis.unpacked() / kGreyLevels;
  surface->basis = packed_terms(basis, Eigen::VectorXf::Constant(basis.cols(), kGreyLevels));
  for (const SampleState state : patch.state) surface->shown.push_back(fraction_of(state));
  patch.mean.resize(0);
  patch.basis = {};
  return surface;
}

std::shared_ptr<const VertexViews> vertex_views(const CompactModel& model, KrigingSystem system,
                                                const ViewKriging& kriging, const Eigen::Vector3f& normal) {
  auto views = std::make_shared<VertexViews>();
  views->directions = std::move(system.directions);
  views->reliability = std::move(system.reliability);
  views->kernel = system.kernel;
  if (kriging.has_drift()) {
    views->reflection = model.reflection;
    views->believed = kriging.believed_drift();
  }
  views->frame = hemisphere_frame(normal);
  views->best_cosine = views->directions.cols() > 0 ? (normal.transpose() * views->directions).maxCoeff() : -1;
  return views;
}

/// Interpolation goes a little beyond the brightest colour that images showed.
FileFacts facts_of(const CompactModel& model) {
  constexpr float kBeyond = 1.1f;
  return {static_cast<float>(model.missing_square / (kGreyLevels * kGreyLevels)),
          kBeyond * model.brightest / kGreyLevels};
}

SnapshotFigures figures_of(const std::vector<std::shared_ptr<const SurfacePatch>>& patches) {
  SnapshotFigures figures;
  std::vector<int> ranks;
  std::size_t samples = 0, seen = 0, measured = 0;
  for (const auto& patch : patches) {
    if (!patch) continue;
    samples += patch->shown.size();
    std::size_t here = 0;
    for (std::size_t s = 0; s < patch->shown.size(); ++s) {
      here += patch->state(static_cast<int>(s)) != SampleState::kUnseen;
      measured += patch->state(static_cast<int>(s)) == SampleState::kMeasured;
    }
    seen += here;
    if (here > 0) ranks.push_back(patch->rank());
  }
  if (samples == 0 || ranks.empty()) return figures;
  figures.seen = static_cast<double>(seen) / static_cast<double>(samples);
  figures.measured = static_cast<double>(measured) / static_cast<double>(samples);
  figures.most_rank = *std::max_element(ranks.begin(), ranks.end());
  figures.median_rank = median_of_both_middles<double>(ranks);
  return figures;
}

}  // namespace

CompactLightField::CompactLightField(CompactModel model, std::shared_ptr<const std::string> encoded)
    : LightFieldSnapshot(model.mesh, model.maps, kOnlySnapshot, model.exposure, model.cameras, facts_of(model)),
      shapes_(model.shapes),
      encoded_(std::move(encoded)) {
  const std::size_t vertices = model.mesh->vertices.size();
  patches_.resize(model.patches.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, patches_.size(), 64), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) patches_[t] = take_surface(model.patches[t]);
  });
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*model.mesh);
  interpolants_.resize(vertices);
  for (std::uint32_t p = 0; p < shapes_.patches.size(); ++p)
    for (std::size_t i = 0; i < shapes_.patches[p].vertices.size(); ++i) {
      Interpolant& here = interpolants_[shapes_.patches[p].vertices[i]];
      here.columns.push_back(shapes_.first_column[p] + static_cast<std::uint32_t>(i));
      here.patches.push_back(p);
    }
  seen_.resize(vertices);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices, 16), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (model.drawn_by(v)) interpolate_at(model, v, normals[model.source[v]]);
  });
  double sum = 0, views = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    const CompactVertex& vertex = model.vertices[v];
    if (!vertex.seen) continue;
    seen_[v] = {interpolants_[v].views, vertex.sill, vertex.residual, vertex.views_folded};
    sum += vertex.sill * static_cast<double>(vertex.views.size());
    views += static_cast<double>(vertex.views.size());
  }
  common_sill_ = views > 0 ? static_cast<float>(sum / views) : 0;
  for (const Patch& patch : model.patches)
    max_terms_ = std::max(max_terms_, static_cast<int>(patch.coefficients.rows()));
  figures_ = figures_of(patches_);
}

void CompactLightField::interpolate_at(const CompactModel& model, std::size_t v, const Eigen::Vector3f& normal) {
  const CompactVertex& vertex = *model.drawn_by(v);
  KrigingSystem system = kriging_system(model, vertex, normal);
  Eigen::Index terms = 0;
  Interpolant& here = interpolants_[v];
  for (const std::uint32_t p : here.patches) terms += model.patches[p].coefficients.rows();
  Eigen::MatrixXf coefficients(terms, system.directions.cols());
  Eigen::Index first = 0;
  for (const std::uint32_t p : here.patches) {
    const Patch& patch = model.patches[p];
    const std::vector<Eigen::Index> at = places(vertex, patch_images(model, shapes_.patches[p]));
    for (std::size_t j = 0; j < at.size(); ++j)
      coefficients.col(static_cast<Eigen::Index>(j)).segment(first, patch.coefficients.rows()) =
          patch.coefficients.col(at[j]);
    first += patch.coefficients.rows();
  }
  const ViewKriging kriging(system.directions, system.reliability, system.kernel, system.drift);
  ViewInterpolant interpolant = kriging.of(coefficients);
  here.views = vertex_views(model, std::move(system), kriging, normal);
  here.weights = PackedColumns<float>::fixed_point(interpolant.weights.transpose());
  here.mean = std::move(interpolant.mean);
  here.drift = std::move(interpolant.drift);
}

bool CompactLightField::seen(std::size_t triangle) const {
  const std::uint32_t patch = shapes_.patch_of[triangle];
  return patches_[patch] != nullptr;
}

TrianglePlace CompactLightField::place(std::size_t triangle) const {
  return shapes_.place(triangle);
}

Eigen::MatrixXf CompactLightField::coefficients_for(const Eigen::Vector3d& eye) const {
  Eigen::MatrixXf coefficients = Eigen::MatrixXf::Zero(1 + max_terms_, static_cast<Eigen::Index>(shapes_.columns()));
  coefficients.row(0).setOnes();  // of the mean map
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, interpolants_.size(), 64), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      const Interpolant& interpolant = interpolants_[v];
      if (!interpolant.views) continue;
      const Eigen::Vector3f direction = (eye.cast<float>() - mesh().vertices[v]).normalized();
      Eigen::VectorXf h(interpolant.mean.size());
      const VertexViews& views = *interpolant.views;
      const Eigen::VectorXf k = covariances(views.kernel, views.directions, direction);
      interpolant.weights.inner_products(k, h);
      h += interpolant.mean;
      if (interpolant.drift.size() > 0) h += views.reflected(direction, k) * interpolant.drift;
      Eigen::Index first = 0;
      for (std::size_t i = 0; i < interpolant.patches.size(); ++i) {
        const auto& patch = patches_[interpolant.patches[i]];
        const Eigen::Index terms = patch ? patch->rank() - 1 : 0;
        coefficients.col(interpolant.columns[i]).segment(1, terms) = h.segment(first, terms);
        first += terms;
      }
    }
  });
  return coefficients;
}

std::shared_ptr<const LightFieldSnapshot> CompactLightField::with_patches(
    const std::vector<std::shared_ptr<const SurfacePatch>>&) const {
  return shared_from_this();  // it never changes: what is not there yet is merely not drawn
}

std::shared_ptr<const ModelSnapshot> CompactLightField::filled() const {
  return shared_from_this();
}

const SeenVertex* CompactLightField::seen_vertex(std::size_t vertex) const {
  return seen_[vertex].views ? &seen_[vertex] : nullptr;
}

std::size_t CompactLightField::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& patch : patches_)
    if (patch) bytes += patch->basis.bytes() + patch->shown.size();
  for (const Interpolant& interpolant : interpolants_)
    bytes += interpolant.weights.bytes() +
             sizeof(float) * static_cast<std::size_t>(interpolant.mean.size() + interpolant.drift.size());
  return bytes;
}

std::unique_ptr<Compression> CompactLightField::compression(CompressionTarget) const {
  throw ConfigError("the model is compressed already; compress the one that it was made from");
}

void CompactLightField::save(const std::filesystem::path& path, const ModelMetadata& metadata, const StepsDone&) const {
  write_file(path, with_notes(kLightFieldFile, *encoded_, metadata, path.string()));
}

}  // namespace sheen
