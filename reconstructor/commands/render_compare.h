// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sheen {

/// Writes each photograph of a data set, a session or a list of lights with the model's picture to its right, and tells
/// the PSNR of each on the object, as `evaluate` measures it, and whether the model was built from it. What was
/// written, for the report. Throws FileError.
nlohmann::json render_comparison(const std::string& model, const std::string& dataset,
                                 const std::filesystem::path& out);

}  // namespace sheen
