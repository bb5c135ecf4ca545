// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/batch_light_field.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/models/surface_light_field/reflection_drift.h"
#include "reconstructor/models/surface_light_field/ring_model.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"
#include "reconstructor/radiance/ring_resampler.h"
#include "reconstructor/surface/map_resolution.h"
#include "reconstructor/surface/view_hemisphere.h"

namespace sheen {
namespace {

constexpr std::size_t kReflectionRings = 1000;  // as many say well enough what all share

/// A ring's factorization on its way to a snapshot.
struct Factored {
  RingMatrix matrix;
  Eigen::MatrixXf basis, coefficients;
  Eigen::VectorXf reliability;
  double residual = 0;  ///< relative, over the known values
};

std::vector<int> in_order(int views) {
  std::vector<int> order(static_cast<std::size_t>(views));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

Factored factored(RingMatrix matrix, const BatchFactorization& how) {
  Factored ring{.matrix = std::move(matrix)};
  MissingPcaOptions missing = how.missing;
  if (how.measures_noise)
    missing.noise = online_factor(ring.matrix, *how.measures_noise, in_order(ring.matrix.views())).row_noise();
  const BatchPca pca = batch_pca_imputed(ring.matrix.columns, ring.matrix.known, how.rank, how.imputing_rank,
                                         ring.matrix.weights(), missing);
  ring.basis = pca.basis.cast<float>();
  ring.coefficients = pca.coefficients.cast<float>();
  ring.residual = pca.relative_error;
  ring.reliability.resize(ring.matrix.views());
  for (int j = 0; j < ring.matrix.views(); ++j)
    ring.reliability[j] = ring.matrix.cosines[j] * static_cast<float>(ring.matrix.share(j));
  return ring;
}

RingLevels levels(const Factored& ring, const Eigen::Vector3f& normal) {
  const Eigen::Index rank = ring.basis.cols();
  if (rank == 0) return {normal, {}, {}, {}};
  Eigen::MatrixXf mean = Eigen::MatrixXf::Zero(3, rank);
  int seen = 0;
  for (Eigen::Index row = 0; row < ring.matrix.known.rows(); row += 3)
    if ((ring.matrix.known.row(row) != 0).any()) {
      mean += ring.basis.middleRows<3>(row);
      ++seen;
    }
  return {normal, ring.matrix.directions, mean / static_cast<float>(std::max(seen, 1)) * ring.coefficients,
          ring.reliability};
}

/// Empty without a shared reflection.
Eigen::VectorXf drift_of_views(const Factored& ring, const ReflectionDrift* reflection, const Eigen::Vector3f& normal) {
  Eigen::VectorXf drift(reflection ? ring.matrix.views() : 0);
  for (Eigen::Index j = 0; j < drift.size(); ++j) drift[j] = reflection->at(ring.matrix.directions.col(j), normal);
  return drift;
}

std::shared_ptr<const RingSnapshot> ring_snapshot(const Factored& ring, const ViewInterpolation& interpolation,
                                                  ViewMethod method,
                                                  const std::shared_ptr<const ReflectionDrift>& reflection,
                                                  const Eigen::Matrix3f& frame, std::span<const int> resolution) {
  auto snapshot = std::make_shared<RingSnapshot>();
  snapshot->basis = ring.basis;
  snapshot->directions = ring.matrix.directions;
  snapshot->reliability = ring.reliability;
  snapshot->frame = frame;
  snapshot->shown.resize(static_cast<std::size_t>(ring.matrix.known.rows() / 3));
  for (std::size_t s = 0; s < snapshot->shown.size(); ++s)
    snapshot->shown[s] = shown_share(
        static_cast<int>((ring.matrix.known.row(static_cast<Eigen::Index>(3 * s)) != 0).count()), ring.matrix.views());
  snapshot->set_interpolation(
      krige(snapshot->directions, ring.coefficients, ring.reliability, interpolation.kernel,
            interpolation.drift ? drift_of_views(ring, reflection.get(), frame.row(2)) : Eigen::VectorXf()),
      interpolation.kernel, reflection);
  if (method == ViewMethod::kDelaunay) snapshot->set_triangulation(ring.coefficients);
  snapshot->residual = static_cast<float>(ring.residual);
  snapshot->best_cosine = ring.matrix.cosines.maxCoeff();
  snapshot->views_folded = ring.matrix.views();
  fill_unseen_samples(*snapshot, resolution);
  return snapshot;
}

}  // namespace

std::vector<double> RingMatrix::weights() const {
  std::vector<double> weights;
  for (int j = 0; j < views(); ++j) weights.push_back(image_weight({}, share(j)));
  return weights;
}

RingFactor online_factor(const RingMatrix& ring, const RingFactorOptions& options, std::span<const int> order) {
  const std::vector<double> weights = ring.weights();
  RingFactor factor(static_cast<int>(ring.columns.rows()), ring_factor_options(options));
  for (const int j : order)
    factor.add(ring.columns.col(j), {ring.known.col(j).data(), static_cast<std::size_t>(ring.known.rows())},
               weights[static_cast<std::size_t>(j)]);
  return factor.settled();
}

BatchLightField::BatchLightField(std::shared_ptr<const Mesh> mesh, const SurfaceLightFieldOptions& options,
                                 std::size_t every)
    : mesh_(std::move(mesh)), options_(options), every_(every), kept_(mesh_->vertices.size()) {}

void BatchLightField::add(const Capture& capture) {
  if (!vertex_rings_) {
    vertex_rings_ = std::make_shared<VertexRings>(
        *mesh_,
        map_resolution(*mesh_, capture.camera, capture.pose.camera_from_object,
                       {options_.surface_map, options_.min_surface_map, options_.max_surface_map, options_.map_scale}));
    visibility_ = std::make_unique<RingVisibility>(*mesh_, *vertex_rings_, options_.visibility);
  }
  const SurfaceView& view = visibility_->look(capture.camera, capture.pose.camera_from_object, usable_pixels(capture));
  image_.load(capture, view);
  resample(image_, view, *vertex_rings_, 1, samples_, options_.sampling);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kept_.size(), 32), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      if (v % every_ != 0) continue;
      RingColumn column;
      if (!gather(*vertex_rings_, v, mesh_->vertices[v], view, samples_, column)) continue;
      const auto shown = static_cast<double>(std::count(column.visible.begin(), column.visible.end(), 1));
      if (shown >= options_.ring.min_visible * static_cast<double>(column.visible.size()))
        kept_[v].push_back({images_, std::move(column)});
    }
  });
  ++images_;
}

std::size_t BatchLightField::bytes() const {
  std::size_t bytes = 0;
  for (const auto& ring : kept_)
    for (const Kept& kept : ring)
      bytes += sizeof(Kept) + sizeof(float) * static_cast<std::size_t>(kept.column.values.size()) +
               kept.column.visible.size();
  return bytes;
}

RingMatrix BatchLightField::ring(std::size_t vertex) const {
  RingMatrix matrix;
  const auto n = static_cast<Eigen::Index>(kept_[vertex].size());
  if (n == 0) return matrix;
  const Eigen::Index rows = kept_[vertex].front().column.values.size();
  matrix.columns.resize(rows, n);
  matrix.known.resize(rows, n);
  matrix.directions.resize(3, n);
  matrix.cosines.resize(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Kept& kept = kept_[vertex][static_cast<std::size_t>(j)];
    for (Eigen::Index i = 0; i < rows; ++i) {
      matrix.known(i, j) = kept.column.visible[static_cast<std::size_t>(i / 3)];
      matrix.columns(i, j) = matrix.known(i, j) ? kept.column.values[i] : 0;
    }
    matrix.directions.col(j) = kept.column.direction;
    matrix.cosines[j] = kept.column.cosine;
    matrix.images.push_back(kept.image);
  }
  return matrix;
}

std::shared_ptr<const SurfaceLightFieldSnapshot> BatchLightField::factorize(const BatchFactorization& how) const {
  std::vector<Factored> rings(kept_.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, kept_.size(), 8), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v)
      if (!kept_[v].empty()) rings[v] = factored(ring(v), how);
  });
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*mesh_);
  std::vector<Eigen::Matrix3f> frames(normals.size());
  std::transform(normals.begin(), normals.end(), frames.begin(), &hemisphere_frame);

  // Between views as the online light field does: with what all rings share, by the errors of all rings.
  std::vector<RingLevels> shared;
  for (std::size_t v = 0; v < rings.size(); v += std::max<std::size_t>(1, rings.size() / kReflectionRings))
    if (rings[v].matrix.views() > 0) shared.push_back(levels(rings[v], frames[v].row(2)));
  const ViewInterpolationOptions& between_views = options_.ring.interpolation;
  const std::shared_ptr<const ReflectionDrift> reflection =
      between_views.drift ? estimate_reflection_drift(shared) : nullptr;
  std::vector<InterpolationErrors> errors(rings.size());
  tbb::parallel_for(std::size_t{0}, rings.size(), [&](std::size_t v) {
    if (rings[v].matrix.views() > 0)
      errors[v] = interpolation_errors(rings[v].matrix.directions, rings[v].coefficients, rings[v].reliability,
                                       drift_of_views(rings[v], reflection.get(), frames[v].row(2)));
  });
  InterpolationChoice choice(*mesh_, between_views);
  for (std::size_t v = 0; v < rings.size(); ++v)
    if (rings[v].matrix.views() > 0) choice.count(static_cast<std::uint32_t>(v), errors[v]);

  std::vector<std::shared_ptr<const RingSnapshot>> data(rings.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, data.size(), 32), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      if (rings[v].matrix.views() == 0) continue;
      std::vector<int> resolution;
      for (const RingTriangle& member : vertex_rings_->ring(v))
        resolution.push_back(vertex_rings_->resolution(member.triangle));
      data[v] = ring_snapshot(rings[v], choice.choose(static_cast<std::uint32_t>(v)), between_views.method, reflection,
                              frames[v], resolution);
    }
  });
  return std::make_shared<SurfaceLightFieldSnapshot>(mesh_, vertex_rings_, std::move(data), 0);
}

}  // namespace sheen
