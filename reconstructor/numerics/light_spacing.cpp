// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/light_spacing.h"

#include <cmath>

namespace sheen {
namespace {

/// Second derivative and kink in units of the brightest exposure, at distance 1.
LightSpacing spacing_of(double curvature, double kink, double tolerance) {
  // Linear interpolation is off by at most B2 dq^2 / 8, bilinear interpolation by twice that. A kink of slope s adds
  // s dq / 4, and the steepest is at the horizon of an element on which the light falls at the least distance.
  LightSpacing spacing;
  spacing.along_line = std::sqrt(8 * tolerance / curvature);
  spacing.on_grid = std::sqrt(4 * tolerance / curvature);
  spacing.on_grid_with_horizon = (std::sqrt(kink * kink / 16 + curvature * tolerance) - kink / 4) / (curvature / 2);
  return spacing;
}

}  // namespace

LightSpacing plan_spacing(const ExposureBounds& bounds, double distance, double tolerance) {
  LightSpacing spacing =
      spacing_of(bounds.point_curvature / bounds.brightest, bounds.horizon_slope / bounds.brightest, tolerance);
  for (double* value : {&spacing.along_line, &spacing.on_grid, &spacing.on_grid_with_horizon}) *value *= distance;
  return spacing;
}

LightSpacing plan_direction_spacing(const ExposureBounds& bounds, double tolerance) {
  return spacing_of(bounds.direction_curvature / bounds.brightest, bounds.horizon_slope / bounds.brightest, tolerance);
}

}  // namespace sheen
