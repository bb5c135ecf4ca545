// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace sheen {

/// A lobe of a reflectance: weight * (L.w)^exponent, with |w| <= 1 any vector that goes with the surface (Lafortune
/// 1997); exponent 0 is a Lambertian one. Only the weights' ratios count.
struct ReflectanceLobe {
  double weight = 1;    ///< > 0
  double exponent = 0;  ///< 0, or at least 1
};

/// How far apart the places of a point light on a plane may be (002 sec. 3), in metres.
struct LightSpacing {
  double along_line = 0;  ///< of lights on a line: linear interpolation
  double on_grid = 0;     ///< of a square grid: bilinear interpolation in both coordinates
  /// The same where a surface may turn away from a light between two places: max(0, N.L) has a kink there, which the
  /// bound of second derivatives knows nothing of.
  double on_grid_with_horizon = 0;
};

/// The spacing at which no element that is lit and in no shadow is off by more than a part `tolerance` (0..1) of the
/// exposure of the brightest element that can be: one that faces the light at the least distance z of the scene from
/// the plane, in metres. Closed form: the second derivative of one lobe's exposure is at most b (k + 3) z^-4 (found
/// numerically for k >= 1, proved for 0), attained by an element that faces the light, at the brightness b z^-2. Eq. 3
/// holds on a line; on a grid both coordinates add to the error, so that the spacing is smaller by sqrt(2).
LightSpacing plan_spacing(std::span<const ReflectanceLobe> lobes, double distance, double tolerance);

}  // namespace sheen
