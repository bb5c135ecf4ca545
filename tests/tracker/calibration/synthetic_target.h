// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <random>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/image/image.h"
#include "tracker/calibration/calibration.h"

namespace sheen::testing {

/// 800 x 600, with every number of Brown-Conrady's model but fy / fx.
Camera ordinary_camera();
/// 800 x 600, about 130 degrees from corner to corner.
Camera fisheye_camera();

struct TargetPoses {
  double most_tilt_deg = 45;
  double least_distance = 0.7, most_distance = 1.5;  ///< 1: the target fills the image's height
  double spread = 0.8;                               ///< of where its middle lies, in parts of the image
  bool z_up = false;                                 ///< the target's z axis comes towards the camera
};
/// A pose under which all of the target's points lie in the image.
Rigid3 random_target_pose(const Camera& camera, std::span<const Eigen::Vector3d> target, std::mt19937& rng,
                          const TargetPoses& poses = {});

/// What each of `views` random poses shows, with Gaussian noise.
std::vector<TargetView> simulated_views(const Camera& camera, std::span<const Eigen::Vector3d> target, int views,
                                        double noise_px, std::mt19937& rng, const TargetPoses& poses = {});

/// The plane z = 0 of a target as a camera sees it: `level` gives the grey level (0..255) of a point of the plane,
/// averaged over 6 x 6 points of each pixel; between the corners of a pixel the plane is interpolated.
ImageU8 render_plane(const Camera& camera, const Rigid3& camera_from_target,
                     const std::function<double(double x, double y)>& level);

}  // namespace sheen::testing
