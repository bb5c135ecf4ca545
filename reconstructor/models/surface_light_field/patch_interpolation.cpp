// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_interpolation.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <span>
#include <utility>

#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/numerics/view_kriging.h"

namespace sheen {
namespace {

/// Empty without a reflection.
Eigen::VectorXf drift_of(const Eigen::Matrix3Xf& directions, const ReflectionDrift* reflection,
                         const Eigen::Vector3f& normal) {
  return reflection ? reflection->at_each(directions, normal) : Eigen::VectorXf();
}

const ReflectionDrift* drift_function(const SharedInterpolation& interpolation) {
  return interpolation.chosen.drift ? interpolation.reflection.get() : nullptr;
}

/// A patch on its way: what its vertices see is there, but not yet what lies between.
struct Begun {
  std::shared_ptr<PatchSnapshot> snapshot;
  Eigen::MatrixXf coefficients;
  ViewSet views;
  std::size_t shown_samples = 0;
};

Begun begun(FactorizedPatch patch, std::size_t vertices) {
  Begun begun{std::make_shared<PatchSnapshot>(), std::move(patch.coefficients), std::move(patch.views), 0};
  PatchSnapshot& snapshot = *begun.snapshot;
  snapshot.basis = std::move(patch.basis);
  snapshot.planes = std::move(patch.planes);
  snapshot.shown = std::move(patch.shown);
  begun.shown_samples = snapshot.shown_samples();
  snapshot.vertices.resize(vertices);
  for (VertexInterpolant& at : snapshot.vertices) {
    at.residual = patch.residual;
    at.views_folded = patch.images;
  }
  return begun;
}

/// What a vertex has of these views, and the kriging between them.
struct Kriged {
  std::shared_ptr<const VertexViews> views;
  ViewKriging kriging;
};

Kriged kriged(const InterpolatedVertex& vertex, SiteViews seen) {
  const SharedInterpolation& interpolation = vertex.interpolation;
  const Eigen::Vector3f normal = vertex.frame.row(2);
  auto views = std::make_shared<VertexViews>();
  views->directions = std::move(seen.directions);
  views->reliability = std::move(seen.reliability);
  views->kernel = interpolation.chosen.kernel;
  views->frame = vertex.frame;
  views->best_cosine = (normal.transpose() * views->directions).maxCoeff();
  ViewKriging kriging(views->directions, views->reliability, views->kernel,
                      drift_of(views->directions, drift_function(interpolation), normal));
  if (kriging.has_drift()) {
    views->reflection = interpolation.reflection;
    views->believed = kriging.believed_drift();
  }
  return {std::move(views), std::move(kriging)};
}

/// All patches that were begun round a vertex.
void interpolate_at(const InterpolatedVertex& vertex, std::span<const PatchVertex> round,
                    const std::vector<std::optional<Begun>>& patches, ViewMethod method) {
  std::vector<PatchVertex> waiting;
  for (const PatchVertex& here : round)
    if (patches[here.patch]) waiting.push_back(here);
  while (!waiting.empty()) {
    const PatchVertex first = waiting.back();
    const ViewSet& views = patches[first.patch]->views;
    const auto same = std::partition(waiting.begin(), waiting.end(), [&](const PatchVertex& other) {
      return !views.same_at_vertex(first.vertex, patches[other.patch]->views, other.vertex);
    });
    const Kriged shared = kriged(vertex, views.seen_from_vertex(first.vertex, vertex.place));
    for (auto here = same; here != waiting.end(); ++here) {
      const Begun& patch = *patches[here->patch];
      VertexInterpolant& at = patch.snapshot->vertices[here->vertex];
      at.views = shared.views;
      at.set_interpolation(shared.kriging.of(patch.coefficients), patch.shown_samples);
      if (method == ViewMethod::kDelaunay) at.set_triangulation(patch.coefficients);
    }
    waiting.erase(same, waiting.end());
  }
}

}  // namespace

std::vector<std::shared_ptr<const PatchSnapshot>> interpolated(
    const PatchShapes& shapes, const MapLayout& maps,
    const std::function<std::optional<FactorizedPatch>(std::uint32_t)>& settle,
    const std::function<InterpolatedVertex(std::uint32_t)>& vertex, ViewMethod method) {
  std::vector<std::optional<Begun>> patches(shapes.patches.size());
  const auto count = static_cast<std::uint32_t>(patches.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, count, 8), [&](const auto& range) {
    for (std::uint32_t p = range.begin(); p < range.end(); ++p)
      if (std::optional<FactorizedPatch> patch = settle(p))
        patches[p] = begun(std::move(*patch), shapes.patches[p].vertices.size());
  });
  const auto vertices = static_cast<std::uint32_t>(shapes.first_round.size() - 1);
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, vertices, 8), [&](const auto& range) {
    for (std::uint32_t v = range.begin(); v < range.end(); ++v)
      interpolate_at(vertex(v), shapes.round(v), patches, method);
  });
  std::vector<std::shared_ptr<const PatchSnapshot>> snapshots(patches.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, count, 32), [&](const auto& range) {
    std::vector<int> resolution;
    for (std::uint32_t p = range.begin(); p < range.end(); ++p) {
      if (!patches[p]) continue;
      resolution.clear();
      for (const std::uint32_t t : shapes.patches[p].triangles) resolution.push_back(maps.resolution(t));
      fill_unseen_samples(*patches[p]->snapshot, resolution);
      snapshots[p] = std::move(patches[p]->snapshot);
    }
  });
  return snapshots;
}

Eigen::VectorXf interpolated(const SiteViews& views, const Eigen::MatrixXf& coefficients,
                             const SharedInterpolation& interpolation, const Eigen::Vector3f& normal,
                             const Eigen::Vector3f& direction) {
  const ReflectionDrift* const reflection = drift_function(interpolation);
  return krige_at(direction, reflection ? reflection->at(direction, normal) : 0, views.directions, coefficients,
                  views.reliability, interpolation.chosen.kernel, drift_of(views.directions, reflection, normal));
}

SmoothedViews smoothed(const SiteViews& views, const Eigen::MatrixXf& coefficients,
                       const SharedInterpolation& interpolation, const Eigen::Vector3f& normal) {
  const ViewKernel& kernel = interpolation.chosen.kernel;
  const Eigen::VectorXf drift = drift_of(views.directions, drift_function(interpolation), normal);
  const ViewKriging kriging(views.directions, views.reliability, kernel, drift);
  const ViewInterpolant interpolant = kriging.of(coefficients);
  SmoothedViews smooth{Eigen::MatrixXf(coefficients.rows(), coefficients.cols()),
                       interpolant.leave_one_out / static_cast<double>(views.reliability.sum())};
  for (Eigen::Index v = 0; v < coefficients.cols(); ++v) {
    const Eigen::VectorXf k = covariances(kernel, views.directions, views.directions.col(v));
    smooth.coefficients.col(v) = interpolant.mean + interpolant.weights * k;
    if (kriging.has_drift()) smooth.coefficients.col(v) += kriging.believed_drift().at(drift[v], k) * interpolant.drift;
  }
  return smooth;
}

InterpolationErrors interpolation_errors(const SiteViews& views, const Eigen::MatrixXf& coefficients,
                                         const ReflectionDrift* reflection, const Eigen::Vector3f& normal) {
  return interpolation_errors(views.directions, coefficients, views.reliability,
                              drift_of(views.directions, reflection, normal));
}

PatchLevels patch_levels(SiteViews views, const Eigen::MatrixXf& mean_rows, const Eigen::MatrixXf& coefficients,
                         const Eigen::Vector3f& normal) {
  if (mean_rows.cols() == 0) return {normal, {}, {}, {}};  // all is black, or waits to be folded
  return {normal, std::move(views.directions), mean_rows * coefficients, std::move(views.reliability)};
}

}  // namespace sheen
