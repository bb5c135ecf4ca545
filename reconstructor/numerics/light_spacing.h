// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/numerics/light_search.h"

namespace sheen {

/// How far apart the places of a light may be (002 sec. 3): metres on a plane, radians of latitude and longitude.
struct LightSpacing {
  double along_line = 0;  ///< of lights on a line: linear interpolation
  double on_grid = 0;     ///< of a square grid: bilinear interpolation in both coordinates
  /// The same where a surface may turn away from a light between two places: max(0, N.L) has a kink there, which the
  /// bound of second derivatives knows nothing of.
  double on_grid_with_horizon = 0;
};

/// The spacing of a point light on a plane at which no element that is lit and in no shadow is off by more than a part
/// `tolerance` (0..1) of the exposure of the brightest element that can be: one that faces the light at the least
/// distance of the scene from the plane, in metres. Eq. 3 holds on a line; on a grid both coordinates add to the error,
/// so that the spacing is smaller by sqrt(2).
LightSpacing plan_spacing(const ExposureBounds& bounds, double distance, double tolerance);

/// The same of far lights, by the angles of their directions' latitude and longitude, in radians (002 sec. 5).
LightSpacing plan_direction_spacing(const ExposureBounds& bounds, double tolerance);

}  // namespace sheen
