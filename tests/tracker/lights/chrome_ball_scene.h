// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/camera/camera.h"
#include "common/image/image.h"

namespace sheen {

/// A lamp that a ball mirrors: a disc of even brightness, far away.
struct FarLamp {
  Eigen::Vector3d towards = Eigen::Vector3d::UnitZ();  ///< unit; x right, y up, z towards the camera
  double radius_deg = 3;
  float radiance = 5;  ///< white is 1: saturated
};

/// Images of a chrome ball in clutter, traced ray by ray, 4 x 4 for each pixel, blurred by a lens, as 8-bit sRGB images
/// hold them.
struct ChromeBallScene {
  int width = 480, height = 360;
  bool ball = true;
  Eigen::Vector2d centre{250.3, 170.8};  ///< pixels; by parallel rays
  double radius = 62.4;
  std::optional<Camera> camera{};                   ///< else rays are parallel
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< of the ball's centre before `camera`, in radii
  double noise = 1;                                 ///< standard deviation, grey levels

  /// Linear light as it is read back, 1 channel.
  ImageF image(const std::vector<FarLamp>& lamps, unsigned seed) const;
};

/// `count` lamps on a dome, from `lowest_deg` above the horizon to the top.
std::vector<FarLamp> lamps_on_dome(int count, double lowest_deg);

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace sheen
