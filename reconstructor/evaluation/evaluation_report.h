// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "reconstructor/evaluation/error_ranking.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/models/baselines.h"

namespace sheen {

/// How views are compared, in words.
inline constexpr const char* kScoreProtocol =
    "object pixels: first hit a front face, inside the mask or eroded by 3 px without one; 8-bit sRGB; mean over views";

/// {file, psnr_db, ssim, ...} per view.
nlohmann::json views_to_json(const Scores& scores);

/// The report of `evaluate`: object, full picture, constant colour, and each view.
nlohmann::json evaluation_report(const Scores& model, const Scores& constant);

/// What a baseline of a model scores on the same pixels.
struct BaselineScores {
  Baseline baseline;
  Scores scores;
};
/// An object per baseline, as `evaluation_report` has them, with its bytes and views.
nlohmann::json baselines_report(std::span<const BaselineScores> baselines);
/// {disk, memory}.
nlohmann::json bytes_report(const Baseline& baseline);
/// A table for a person: a line per baseline, the last for the model, and what that is above each of those that keep
/// photographs.
void print_baselines(std::span<const BaselineScores> baselines, const BaselineScores& model);

nlohmann::json ranking_report(const ErrorRanking& ranking);
nlohmann::json calibration_report(const ErrorCalibration& calibration);
/// What the model predicted of each of these views before and after calibration by the others, and what came of it.
nlohmann::json prediction_report(const Scores& scores);
/// The same for a person: a line per view, one for all, and how well it ranks the errors of triangles.
void print_predictions(const Scores& scores, const ErrorRanking& ranking, const std::string& peer_title);

/// A line for a person: what held-out views say, beside the constant colour's figure.
void print_scores(double psnr_db, double ssim, double constant_psnr_db);

/// A report as its file holds it; what is no UTF-8 (the name of a file) is replaced, not refused.
std::string to_text(const nlohmann::json& report);

}  // namespace sheen
