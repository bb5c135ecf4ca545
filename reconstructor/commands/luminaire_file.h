// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/capture/lighting.h"

namespace sheen {

/// A picture and the lights that are on in it together.
struct LitPicture {
  std::string name;
  std::vector<LightState> lights;
};

/// Pictures of a file of lamps (JSON, described in docs/user_guide.md) as lights of the kinds that a model was built
/// in; `known`: its lights. Maps of environments are looked for beside the file; what is left out of them is printed.
/// Throws FileError that names the field, and ConfigError.
std::vector<LitPicture> load_luminaires(const std::filesystem::path& file, std::span<const LightState> known);

/// The same of one map of an environment.
LitPicture load_environment(const std::filesystem::path& map, std::span<const LightState> known);

}  // namespace sheen
