// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/batch_light_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>
#include <optional>

#include "reconstructor/models/surface_light_field/interpolation_upkeep.h"
#include "reconstructor/models/surface_light_field/patch_interpolation.h"
#include "reconstructor/models/surface_light_field/reflection_fit.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"
#include "reconstructor/radiance/resampling.h"
#include "reconstructor/surface/map_resolution.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

constexpr std::size_t kReflectionPatches = 1000;  // as many say well enough what all share

/// A patch's factorization on its way to a snapshot.
struct Factored {
  FactorizedPatch patch;
  SurfaceSite centre;
};

std::vector<int> in_order(int views) {
  std::vector<int> order(static_cast<std::size_t>(views));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

Factored factored(const PatchMatrix& matrix, const SurfaceSite& centre, const BatchFactorization& how) {
  MissingPcaOptions missing = how.missing;
  if (how.measures_noise)
    missing.noise = online_factor(matrix, *how.measures_noise, in_order(matrix.views())).row_noise();
  const BatchPca pca =
      batch_pca_imputed(matrix.columns, matrix.known, how.rank, how.imputing_rank, matrix.weights(), missing);
  FactorizedPatch patch{.basis = Eigen::MatrixXf(pca.basis.cast<float>()),
                        .coefficients = pca.coefficients.cast<float>(),
                        .shown = {},
                        .residual = static_cast<float>(pca.relative_error),
                        .images = matrix.views(),
                        .views = ViewSet(centre.place, static_cast<std::size_t>(matrix.reliability.rows()))};
  for (Eigen::Index row = 0; row < matrix.known.rows(); row += 3)
    patch.shown.push_back(shown_fraction(static_cast<int>((matrix.known.row(row) != 0).count()), matrix.views()));
  for (int j = 0; j < matrix.views(); ++j)
    patch.views.add(matrix.eyes.col(j),
                    {matrix.reliability.col(j).data(), static_cast<std::size_t>(matrix.reliability.rows())});
  return {std::move(patch), centre};
}

PatchLevels levels(const Factored& factored) {
  const FactorizedPatch& patch = factored.patch;
  const Eigen::MatrixXf basis = patch.basis.unpacked();
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, basis.cols());
  int seen = 0;
  for (std::size_t s = 0; s < patch.shown.size(); ++s)
    if (patch.shown[s] > 0) {
      mean += basis.middleRows<3>(static_cast<Eigen::Index>(3 * s));
      ++seen;
    }
  return patch_levels(patch.views.seen_from_centre(), mean / static_cast<float>(std::max(seen, 1)), patch.coefficients,
                      factored.centre.normal);
}

}  // namespace

std::vector<double> PatchMatrix::weights() const {
  std::vector<double> weights;
  for (int j = 0; j < views(); ++j) weights.push_back(image_weight({}, fraction(j)));
  return weights;
}

OnlineSvd online_factor(const PatchMatrix& patch, const OnlineSvdOptions& options, std::span<const int> order) {
  const std::vector<double> weights = patch.weights();
  OnlineSvd factor(static_cast<int>(patch.columns.rows()), patch_factor_options(options));
  for (const int j : order)
    factor.add(patch.columns.col(j), {patch.known.col(j).data(), static_cast<std::size_t>(patch.known.rows())},
               weights[static_cast<std::size_t>(j)]);
  return factor.settled();
}

BatchLightField::BatchLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options,
                                 std::size_t every)
    : mesh_(std::move(mesh)), options_(options), every_(every) {}

void BatchLightField::add(const Capture& capture) {
  if (!maps_) {
    maps_ = std::make_shared<MapLayout>(
        map_resolution(*mesh_, capture.camera, capture.pose.camera_from_object,
                       {options_.surface_map, options_.min_surface_map, options_.max_surface_map, options_.map_scale}));
    visibility_ = std::make_unique<SampleVisibility>(*mesh_, *maps_, options_.visibility);
    shapes_ = std::make_shared<const PatchShapes>(cut_into_patches(*mesh_, *maps_, options_.patch.size));
    kept_.resize(shapes_->patches.size());
  }
  const SurfaceView& view = visibility_->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  image_.load(capture, view);
  const std::vector<float> at_vertices = reliability_at_vertices(*mesh_, *maps_, view);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kept_.size(), 32), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p) {
      if (p % every_ != 0) continue;
      PatchColumn column;
      if (!gather(shapes_->patches[p], {image_, view, *maps_, 1, options_.sampling}, column)) continue;
      const auto shown = static_cast<double>(std::count(column.visible.begin(), column.visible.end(), 1));
      if (shown < options_.patch.min_visible * static_cast<double>(column.visible.size())) continue;
      std::vector<float> reliability;
      for (const std::uint32_t v : shapes_->patches[p].vertices) reliability.push_back(at_vertices[v]);
      kept_[p].push_back({images_, std::move(column), view.eye.cast<float>(), std::move(reliability)});
    }
  });
  ++images_;
}

std::size_t BatchLightField::bytes() const {
  std::size_t bytes = 0;
  for (const auto& patch : kept_)
    for (const Kept& kept : patch)
      bytes += sizeof(Kept) + sizeof(float) * static_cast<std::size_t>(kept.column.values.size()) +
               kept.column.visible.size();
  return bytes;
}

PatchMatrix BatchLightField::patch(std::size_t index) const {
  PatchMatrix matrix;
  const auto n = static_cast<Eigen::Index>(kept_[index].size());
  if (n == 0) return matrix;
  const Eigen::Index rows = kept_[index].front().column.values.size();
  matrix.columns.resize(rows, n);
  matrix.known.resize(rows, n);
  matrix.eyes.resize(3, n);
  matrix.reliability.resize(static_cast<Eigen::Index>(shapes_->patches[index].vertices.size()), n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Kept& kept = kept_[index][static_cast<std::size_t>(j)];
    for (Eigen::Index i = 0; i < rows; ++i) {
      matrix.known(i, j) = kept.column.visible[static_cast<std::size_t>(i / 3)];
      matrix.columns(i, j) = matrix.known(i, j) ? kept.column.values[i] : 0;
    }
    matrix.eyes.col(j) = kept.eye;
    matrix.reliability.col(j) = Eigen::Map<const Eigen::VectorXf>(kept.reliability.data(), matrix.reliability.rows());
    matrix.images.push_back(kept.image);
  }
  return matrix;
}

std::shared_ptr<const SurfaceLightFieldSnapshot> BatchLightField::factorize(const BatchFactorization& how) const {
  std::vector<std::unique_ptr<Factored>> patches(kept_.size());  // null where no image shows enough
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kept_.size(), 8), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p)
      if (!kept_[p].empty())
        patches[p] = std::make_unique<Factored>(factored(patch(p), centre_of(*mesh_, shapes_->patches[p]), how));
  });
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*mesh_);

  // Between views as the online light field does: with what all patches share, by the errors of all patches.
  std::vector<PatchLevels> shared;
  for (std::size_t p = 0; p < patches.size(); p += std::max<std::size_t>(1, patches.size() / kReflectionPatches))
    if (patches[p]) shared.push_back(levels(*patches[p]));
  const ViewInterpolationOptions& between_views = options_.patch.interpolation;
  const std::shared_ptr<const ReflectionDrift> reflection =
      between_views.drift ? estimate_reflection_drift(shared) : nullptr;
  std::vector<InterpolationErrors> errors(patches.size());
  tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t p) {
    if (patches[p])
      errors[p] = interpolation_errors(patches[p]->patch.views.seen_from_centre(), patches[p]->patch.coefficients,
                                       reflection.get(), patches[p]->centre.normal);
  });
  InterpolationChoice choice(shapes_, between_views);
  for (std::size_t p = 0; p < patches.size(); ++p)
    if (patches[p]) choice.count(static_cast<std::uint32_t>(p), errors[p]);
  std::vector<ViewInterpolation> chosen(choice.vertices());
  for (std::uint32_t v = 0; v < chosen.size(); ++v)
    if (choice.can_choose(v)) chosen[v] = choice.choose(v);

  const auto settle = [&](std::uint32_t p) {
    return patches[p] ? std::optional(std::move(patches[p]->patch)) : std::nullopt;
  };
  const auto at_vertex = [&](std::uint32_t v) {
    return InterpolatedVertex{mesh_->vertices[v], hemisphere_frame(normals[v]), {chosen[v], reflection}};
  };
  SurfaceLightFieldSnapshot::Patches data = interpolated(*shapes_, *maps_, settle, at_vertex, between_views.method);
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh_, maps_, shapes_, std::move(data), 0);
}

}  // namespace sheen
