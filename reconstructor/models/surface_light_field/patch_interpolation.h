// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/models/surface_light_field/patch_snapshot.h"
#include "reconstructor/models/surface_light_field/reflection_fit.h"
#include "reconstructor/models/surface_light_field/view_interpolation.h"
#include "reconstructor/models/surface_light_field/view_set.h"

namespace sheen {

/// How one vertex interpolates between views, and the reflection that all share (null: there is none yet).
struct SharedInterpolation {
  ViewInterpolation chosen;
  std::shared_ptr<const ReflectionDrift> reflection;
};

/// A vertex of a patch.
struct InterpolatedVertex {
  Eigen::Vector3f place;
  Eigen::Matrix3f frame;  ///< of its hemisphere
  SharedInterpolation interpolation;
};

/// A patch of which everything is known but what lies between its views.
struct FactorizedPatch {
  PackedColumns<float> basis;  ///< as `SurfacePatch` has it, and the following
  std::shared_ptr<const ColourPlanes> planes;
  Eigen::MatrixXf coefficients;  ///< rank x views
  std::vector<std::uint8_t> shown;
  float residual = 0;  ///< `SeenVertex::residual`
  int images = 0;      ///< ingested
  ViewSet views;
};

/// Patches with their views' coefficients interpolated at each of their vertices, and with a guess where no image
/// showed them (`fill_unseen_samples`); null where `settle` has none. `settle` is asked once for each patch, on many
/// threads, and may let go of what it gives. Kriging costs the cube of the number of views: patches that share a vertex
/// and have the same views there share it.
std::vector<std::shared_ptr<const PatchSnapshot>> interpolated(
    const PatchShapes& shapes, const MapLayout& maps,
    const std::function<std::optional<FactorizedPatch>(std::uint32_t patch)>& settle,
    const std::function<InterpolatedVertex(std::uint32_t vertex)>& vertex, ViewMethod method);

/// Coefficients from a direction, at a place where the surface has this normal.
Eigen::VectorXf interpolated(const SiteViews& views, const Eigen::MatrixXf& coefficients,
                             const SharedInterpolation& interpolation, const Eigen::Vector3f& normal,
                             const Eigen::Vector3f& direction);

/// The views of a patch as they are displayed.
struct SmoothedViews {
  Eigen::MatrixXf coefficients;  ///< rank x views: interpolated from each, smoothed by what the kernel takes for noise
  double squared_error = 0;      ///< of the coefficients of a view, as predicted from the others; mean over views
};
SmoothedViews smoothed(const SiteViews& views, const Eigen::MatrixXf& coefficients,
                       const SharedInterpolation& interpolation, const Eigen::Vector3f& normal);

/// Errors with the drift are infinite without a reflection, and with too few views.
InterpolationErrors interpolation_errors(const SiteViews& views, const Eigen::MatrixXf& coefficients,
                                         const ReflectionDrift* reflection, const Eigen::Vector3f& normal);

/// Of a patch, from its mean basis row per channel (3 x rank).
PatchLevels patch_levels(SiteViews views, const Eigen::MatrixXf& mean_rows, const Eigen::MatrixXf& coefficients,
                         const Eigen::Vector3f& normal);

}  // namespace sheen
