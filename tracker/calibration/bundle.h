// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "tracker/calibration/lens_functions.h"

namespace sheen {

using Intrinsics = Eigen::Matrix<double, kIntrinsics, 1>;

Intrinsics intrinsics_of(const Camera& camera);
Camera with_intrinsics(Camera camera, const Intrinsics& values);

/// A point of the object, seen in a view.
struct BundleSighting {
  int view = 0, point = 0;
  Eigen::Vector2d pixel;
};

/// Which of the unknowns of a bundle adjustment are estimated; poses always are.
struct BundleFreedom {
  std::array<bool, kIntrinsics> intrinsics{};
  bool points = false;
  int intrinsics_count() const;
};

/// One camera, several views, points: what a calibration (points known) and a stage survey (camera known) have in
/// common.
struct Bundle {
  Camera camera;
  std::vector<Rigid3> camera_from_object;  ///< of each view
  std::vector<Eigen::Vector3d> points;     ///< metres, object frame
  std::vector<BundleSighting> sightings;
  BundleFreedom free;
};

/// Minimises the reprojection error of all sightings, by Levenberg-Marquardt with the Schur complement (Ceres).
/// `huber_px` 0: least squares. Throws Error when a point lies behind its camera at the start.
void solve(Bundle& bundle, double huber_px = 0);

/// pixel seen - pixel predicted, of each sighting.
std::vector<Eigen::Vector2d> residuals(const Bundle& bundle);

/// J^T J of the reprojection errors (1/px^2 for a noise of 1 px) over the free intrinsics, 6 numbers per view (rotation
/// vector added to that of the pose; translation), and 3 per point if they are free.
Eigen::MatrixXd information(const Bundle& bundle);

/// Derivative of a pixel by the intrinsics, and by a small rotation vector of its ray.
struct PixelDerivative {
  Eigen::Matrix<double, 2, kIntrinsics> intrinsics;
  Eigen::Matrix<double, 2, 3> rotation;
};
PixelDerivative pixel_derivative(const Camera& camera, const Eigen::Vector3d& ray);

}  // namespace sheen
