// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"

namespace sheen {

/// A hand-held walk round the object: a rising spiral whose views stand about evenly on the part of the sphere that it
/// covers, unsteady in distance, aim and roll as a person is, with a jerk now and then.
struct CameraPathOptions {
  int frames = 130;
  double lowest_deg = 18, highest_deg = 75;  ///< elevation
  double nearest_m = 0.50, farthest_m = 0.62;
  Eigen::Vector3d target{0, 0, 0.045};  ///< metres, object frame
  double aim_jitter_m = 0.006;
  double roll_jitter_deg = 5;
  int jerk_every = 32;  ///< frames between two that motion blurs; 0 = never
  double jerk_px = 12;  ///< about the length of their streaks
  std::uint64_t seed = 1;
};

/// Where the camera is while one frame is exposed. It turns evenly about `swing` (rad, camera axes), half of it before
/// the pose and half after; zero when it keeps still.
struct CameraStation {
  Rigid3 camera_from_object;  ///< at the middle of the exposure
  Eigen::Vector3d swing = Eigen::Vector3d::Zero();

  bool moves() const { return swing != Eigen::Vector3d::Zero(); }
  /// The pose at `moment` of the exposure, -0.5 to 0.5.
  Rigid3 at(double moment) const;
  /// Length of the streak that a point of the object draws, pixels.
  double streak_px(const Camera& camera, const Eigen::Vector3d& point) const;
};

/// Throws ConfigError naming the option that is out of range.
std::vector<CameraStation> camera_path(const CameraPathOptions& options, const Camera& camera);

/// The simulated camera: 1024x768, f = 1200 px, Brown-Conrady distortion with k1 = -0.1; scaled to another size.
Camera simulated_camera(int width, int height);

}  // namespace sheen
