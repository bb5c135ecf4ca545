// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "tracker/calibration/lens_fit.h"
#include "tracker/calibration/target_finder.h"

namespace sheen {

/// What was found of the target in one image.
struct TargetView {
  std::string name;  ///< of the image's file
  std::vector<TargetSighting> sightings;
};

struct CalibrationOptions {
  double outlier_sigmas = 5;       ///< a corner farther off than this is not used; of Gaussian noise 4 in a million are
  double outlier_floor_px = 0.02;  ///< nor is any nearer than this an outlier
  double fewest_kept = 0.6;        ///< of a view's corners; a view that keeps fewer is not used at all
};

struct RejectedCorner {
  int point = 0;
  double error_px = 0;
};

struct CalibratedView {
  std::string name;
  bool used = false;
  std::string reason;  ///< why it is not used
  Rigid3 camera_from_target;
  int corners = 0;        ///< found
  double rms_px = 0;      ///< of the corners used; of all where the view is not used
  double rms_all_px = 0;  ///< of the corners found
  std::vector<RejectedCorner> rejected;
};

/// A camera with what its images say of its accuracy. RMS: of the distance between a corner and its prediction.
struct Calibration {
  const LensFit* fit = nullptr;
  Camera camera;
  std::vector<CalibratedView> views;  ///< as they were given
  std::vector<TargetView> used;       ///< the sightings that the camera rests on
  double rms_px = 0;                  ///< over those
  double rms_all_px = 0;              ///< over all corners found, rejected ones too
  double noise_px = 0;                ///< standard deviation of a coordinate: sqrt(sum r^2 / (2 corners - unknowns))
  /// Of `Intrinsics`; 0 for what is not estimated. noise^2 (J^T J)^-1, poses marginalised.
  Eigen::Matrix<double, kIntrinsics, kIntrinsics> covariance;

  int corners_used() const;
};

/// Estimates camera and poses from all views at once (Zhang 2000): a start from the focal length that fits best, robust
/// and then least-squares bundle adjustment, corners and views that disagree dropped and judged again until nothing
/// changes. Throws Error when fewer than three views are usable or they do not determine the camera.
Calibration calibrate(std::span<const Eigen::Vector3d> target, std::span<const TargetView> views, ImageSize size,
                      const LensFit& fit, const CalibrationOptions& options = {});

/// The same from sightings that are known to be good, beginning at a camera that is nearly right.
Calibration recalibrate(std::span<const Eigen::Vector3d> target, std::span<const TargetView> good, const Camera& start,
                        const LensFit& fit);

}  // namespace sheen
