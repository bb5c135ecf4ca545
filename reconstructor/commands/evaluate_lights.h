// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace sheen {

/// Scores a saved model that knows moving light on images in lights that it never saw, and prints a line for each: the
/// report of `evaluate`. Throws ConfigError for a model of fixed light or of another kind of light.
nlohmann::json evaluate_lights(const std::filesystem::path& model, const std::filesystem::path& list);

}  // namespace sheen
