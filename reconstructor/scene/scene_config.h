// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "reconstructor/effort/budget.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"

namespace sheen {

/// What a scene file says of the model: keys of [surface_light_field]. docs/user_guide.md says what each is for,
/// deploy/examples/scene.toml has their defaults.
struct SceneConfig {
  SurfaceLightFieldOptions surface_light_field;
  MeasuredLadder ladder;  ///< [[rung]], as `tradeoff` writes it; empty where the file has none
};

/// Throws ConfigError or FileError naming file, line and key; unknown keys are errors.
SceneConfig load_scene_config(const std::filesystem::path& file);
/// The same of a text that stands in `file`.
SceneConfig parse_scene_config(std::string_view text, const std::filesystem::path& file);

/// The scene file of these options, to be written and loaded again: all keys.
std::string to_toml(const SurfaceLightFieldOptions& options);
std::string rungs_to_toml(const MeasuredLadder& ladder);

}  // namespace sheen
