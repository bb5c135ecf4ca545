// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "tracker/calibration/calibration.h"

namespace sheen {

/// What the images themselves say of the target's points, taken as unknown (Strobl and Hirzinger 2011), after the
/// similarity that fits them best to the points that were given.
struct TargetShape {
  double rms_px = 0;          ///< with free points, to hold against the calibration's
  double out_of_plane_m = 0;  ///< farthest from the plane
  double in_plane_m = 0;      ///< farthest from where it was said to be, along the plane
  /// F statistic of the improvement: about 1 where the points are right and the errors of the corners independent.
  double significance = 0;
};

/// From a calibration's own sightings; points that fewer than three views show are left out. Throws Error when fewer
/// than eight are left.
TargetShape estimate_target_shape(std::span<const Eigen::Vector3d> target, const Calibration& calibration);

}  // namespace sheen
