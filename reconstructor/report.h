// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "reconstructor/reconstruction.h"

namespace sheen {

/// The part of a report that `build` and `serve` share: frames, rates, stages, ranks, bytes, held-out scores beside
/// those of the constant-colour model.
nlohmann::json reconstruction_report(Reconstruction& reconstruction);

/// The report of `evaluate`: object, full picture, constant colour, and each view.
nlohmann::json evaluation_report(const Scores& light_field, const Scores& constant);

/// One line for a person: held-out figures beside the constant colour's.
void print_summary(const nlohmann::json& report);

/// {file, psnr_db, ssim, ...} a view.
nlohmann::json views_to_json(const Scores& scores);

/// Throws FileError. "-" is standard output.
void write_json(const std::filesystem::path& path, const nlohmann::json& json);

}  // namespace sheen
