// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/registration/placement.h"
#include "tracker/calibration/correspondences.h"

namespace sheen {

/// What became of a correspondence.
struct RegisteredPoint {
  std::string name;
  bool used = true;          ///< false: an outlier
  Eigen::Vector3d stage;     ///< metres; where it was picked, or where its pixels meet
  Eigen::Vector3d residual;  ///< `stage` less where the mesh has it, metres
  double residual_px = 0;    ///< RMS over its pixels; 0 for a point of the stage
  double sigmas = 0;         ///< distance from where the others have it, in standard deviations of that
  double from_surface = 0;   ///< of the mesh's point from the mesh, in the mesh's numbers
};

struct PointRegistration {
  Placement placement;
  std::vector<RegisteredPoint> points;
  double rms_m = 0;             ///< of the residuals of those used
  double noise_m = 0;           ///< standard deviation of a coordinate
  bool noise_estimated = true;  ///< from the residuals; false: as the file says
  int degrees_of_freedom = 0;   ///< equations less unknowns, of those used
  std::vector<std::string> warnings;
};

/// The similarity (`free_scale`) or rigid motion with `scale` (metres per unit of the mesh) that fits the points best
/// (Umeyama 1991), weighted where pixels know them better in one direction. Outliers are found by leaving them out,
/// from the three points that fit best on, and named. `views`: cameras by the image's name; pixels of a point are
/// intersected first. Throws ConfigError where the points cannot say it: too few, on one line, mirrored, of another
/// unit; names which.
struct PointOptions {
  bool free_scale = false;
  double scale = 1;
};
PointRegistration register_points(const Correspondences& picked, const Mesh& mesh,
                                  const std::map<std::string, PosedCamera>& views, const PointOptions& options);

}  // namespace sheen
