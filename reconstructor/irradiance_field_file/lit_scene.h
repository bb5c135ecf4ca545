// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "reconstructor/numerics/point_kriging.h"

namespace sheen {

/// What an irradiance field knows of its scene beside the pictures: one camera, and where its lights were.
struct LitScene {
  PosedCamera camera;
  LightKind kind = LightKind::kDirectional;  ///< or kPoint
  Eigen::Matrix3Xd lights;                   ///< 3 x n: unit directions towards the lights, or positions; object frame
  PointKernel kernel;
  double error = 0;  ///< RMS of encoded values, 0..1, of predicting an image from the others
};

/// The plane on which near lights moved: x.normal = distance, > 0. None where they did not, or where it goes through
/// the object's origin.
struct LightPlane {
  Eigen::Vector3d normal;
  double distance = 0;
  /// Where the way from the origin through a point meets it; none where it does not.
  std::optional<Eigen::Vector3d> meet(const Eigen::Vector3d& point) const;
};
std::optional<LightPlane> light_plane(const LitScene& scene);

}  // namespace sheen
