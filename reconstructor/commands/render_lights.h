// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace sheen {

/// Renders a saved model that knows moving light, seen by its own camera, in each light of a list: linear EXR and PNG,
/// named as in the list. Throws ConfigError for a model of fixed light or of another kind of light.
void render_lights(const std::filesystem::path& model, const std::filesystem::path& list,
                   const std::filesystem::path& out);

}  // namespace sheen
