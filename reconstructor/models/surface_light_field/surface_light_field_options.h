// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/models/surface_light_field/ring_model.h"
#include "reconstructor/radiance/radiance_image.h"
#include "reconstructor/surface/ring_visibility.h"

namespace sheen {

/// How images of differing exposure are brought to one level.
enum class ExposureCompensation {
  kOff,       ///< grey levels mean the same in all images
  kKnown,     ///< by exposure time and gain where a linear camera reports them
  kEstimate,  ///< as kKnown; where they are unknown, one robust gain an image (docs/decisions/exposure.md)
};

struct SurfaceLightFieldOptions {
  /// Side of a triangle's surface map; 0 = from the footprint of a pixel in the first image.
  int surface_map = 0;
  int min_surface_map = 4, max_surface_map = 24;  ///< bounds of the choice by footprint (MapResolutionOptions)
  double map_scale = 1;                           ///< of the side, given or chosen
  Sampling sampling = Sampling::kCubic;
  int hold_out_every = 8;  ///< every Nth image of a source is held out; 0 = none
  ExposureCompensation exposure = ExposureCompensation::kKnown;
  VisibilityOptions visibility;
  RingModelOptions ring;
};

/// Throws ConfigError when an option is out of range, naming it.
void require_valid(const SurfaceLightFieldOptions& options);

}  // namespace sheen
