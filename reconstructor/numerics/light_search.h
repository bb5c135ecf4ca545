// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "reconstructor/numerics/reflectance.h"

namespace sheen {

/// What the exposure of a surface does at most when its light moves (002 sec. 3.3), whatever its normal and place. z is
/// the least distance of the scene from the plane on which a point light of intensity 1 moves.
struct ExposureBounds {
  double brightest = 0;            ///< exposure of the brightest element, times z^2
  double point_curvature = 0;      ///< second derivative along a line of the light's plane (B2), times z^4
  double direction_curvature = 0;  ///< of a far light, by the angle of its latitude or longitude: per square radian
  /// Slope at the horizon, where max(0, N.L) has a kink: times z^3 of a point light, per radian of a far one.
  double horizon_slope = 0;
};

/// Of lobes, in closed form: (k + 3) per lobe for a point light and k + 1 for a far one, of the weight, found at an
/// element that faces the light with all lobes towards it. Proved for k = 0, checked by `search_bounds` for the others.
ExposureBounds lobe_bounds(std::span<const ReflectanceLobe> lobes);

/// Of any reflectance, by a search over all normals, eyes and light directions: a grid, close round the highlights,
/// then the best of it improved. Distance needs no search: an element right at the plane's least distance is the worst,
/// and of all planes through the light the one that is squarest to it. The bounds are 1 % above what is found, and
/// within 2 % of the true suprema.
ExposureBounds search_bounds(const Reflectance& reflectance);

}  // namespace sheen
