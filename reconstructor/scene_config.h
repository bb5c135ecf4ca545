// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "reconstructor/models/surface_light_field/surface_light_field.h"

namespace sheen {

/// What a scene file says of the model. See docs/user_guide.md for the keys.
///
///   [surface_light_field]
///   surface_map = 0            # side of a triangle's map; 0 = from the footprint of a pixel
///   map_scale = 1              # of that side
///   sampling = "cubic"         # how images are read between pixels: "cubic" or "linear"
///   max_rank = 24              # terms a ring
///   tolerance = 0.01           # relative error a ring may keep
///   max_views = 64             # directions kept a ring
///   repeat_angle = 0.0175      # rad from a kept view within which an image that shows the same adds nothing; 0 =
///   never min_visible = 0.1          # share of a ring that an image must show hold_out_every = 8         # every Nth
///   image judges the model instead of feeding it; 0 = none exposure = "known"         # "off", "known" (what a linear
///   camera reports) or "estimate" (photographs) erosion_px = 1             # kept away from silhouettes
struct SceneConfig {
  SurfaceLightFieldOptions surface_light_field;
};

/// Throws ConfigError or FileError naming file, line and key; unknown keys are errors.
SceneConfig load_scene_config(const std::filesystem::path& file);

/// The scene file of these options, to be written and loaded again: all keys.
std::string to_toml(const SurfaceLightFieldOptions& options);

}  // namespace sheen
