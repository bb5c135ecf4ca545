// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/light_spacing.h"

#include <cmath>

namespace sheen {

LightSpacing plan_spacing(std::span<const ReflectanceLobe> lobes, double distance, double tolerance) {
  double brightness = 0, curvature = 0;
  for (const ReflectanceLobe& lobe : lobes) {
    brightness += lobe.weight;
    curvature += lobe.weight * (lobe.exponent + 3);
  }
  curvature /= brightness;  // B2 z^4 over the brightest exposure times z^2
  // Linear interpolation is off by at most B2 dq^2 / 8, bilinear interpolation by twice that. A kink of slope s adds
  // s dq / 4, and the steepest is at the horizon of an element on which the light falls at the least distance: s =
  // z^-3.
  LightSpacing spacing;
  spacing.along_line = distance * std::sqrt(8 * tolerance / curvature);
  spacing.on_grid = distance * std::sqrt(4 * tolerance / curvature);
  spacing.on_grid_with_horizon = distance * (std::sqrt(0.0625 + curvature * tolerance) - 0.25) / (curvature / 2);
  return spacing;
}

}  // namespace sheen
