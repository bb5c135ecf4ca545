// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/capture/saved_model.h"

namespace sheen {

/// Scores a saved model that knows moving light on images in lights that it never saw, in messages called
/// `name`: the report of `evaluate`; `told`: a line for each, too. Throws ConfigError for a model of fixed light or of
/// another kind of light.
nlohmann::json evaluate_lights(const SavedModel& model, const std::string& name, const std::filesystem::path& list,
                               bool told);

}  // namespace sheen
