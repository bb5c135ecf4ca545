// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "reconstructor/effort/effort_control.h"
#include "reconstructor/models/model_kind.h"

namespace sheen {

/// What a scene file says: which model, with which settings. docs/user_guide.md says what each key is for,
/// deploy/examples/scene.toml has their defaults.
struct SceneConfig {
  const ModelKind* kind = nullptr;          ///< `model = "..."`; the first known kind where the file does not say
  std::unique_ptr<ModelSettings> settings;  ///< [images], [NAME], [NAME.advanced]
  MeasuredLevels measured;  ///< [[effort_level]], as `tradeoff` writes it; empty where the file has none
};

/// What a scene without a file has. `model`: name of a kind, in which - may stand for _; the first known kind where it
/// is empty. Throws ConfigError.
SceneConfig default_scene(const std::string& model = {});
/// Throws ConfigError or FileError naming file, line and key; unknown keys are errors.
SceneConfig load_scene_config(const std::filesystem::path& file);
/// The same of a text that stands in `file`. `chosen`: the kind where it says `model = "auto"`, which else is an error.
SceneConfig parse_scene_config(std::string_view text, const std::filesystem::path& file,
                               const ModelKind* chosen = nullptr);
/// Whether a scene says `model = "auto"`.
bool scene_chooses_model(std::string_view text, const std::filesystem::path& file);

/// The scene file of these settings, to be written and loaded again: all keys.
std::string to_toml(const ModelSettings& settings);
std::string levels_to_toml(const MeasuredLevels& measured);

}  // namespace sheen
