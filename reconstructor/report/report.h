// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/base/progress.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/evaluation/foretelling.h"

namespace sheen {

/// The part of a report that `build` and `serve` share: frames, rates, stages, ranks, bytes, held-out scores beside
/// those of the constant-colour model. `judged`: by `Reconstruction::judge`.
nlohmann::json reconstruction_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged);
/// The same of a live capture, with what only its loop knows: what waits, what was lost, how long it took to be
/// durable.
nlohmann::json live_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged,
                           const LoopStatus& status);

/// The report of `evaluate`: object, full picture, constant colour, and each view.
nlohmann::json evaluation_report(const Scores& light_field, const Scores& constant);

/// What the same pixels score without a surface light field.
struct BaselineScores {
  Scores constant_colour;
  Scores nearest_photograph;      ///< all photographs kept
  Scores unstructured_lumigraph;  ///< all photographs kept
};
/// An object a baseline, as `evaluation_report` has them, with its views.
nlohmann::json baselines_report(const BaselineScores& baselines);
/// A table for a person: a line a baseline, one for the light field, and what that is above the lumigraph.
void print_baselines(const Scores& light_field, const BaselineScores& baselines);

nlohmann::json foretelling_report(const Foretelling& foretelling);
/// What the model predicted of each of these views before and after calibration by the others, and what came of it.
nlohmann::json prediction_report(const Scores& scores);
/// The same for a person: a line a view, one for all, and how well it ranks the errors of triangles.
void print_predictions(const Scores& scores, const Foretelling& foretelling);

/// One line for a person: held-out figures beside the constant colour's.
void print_summary(const nlohmann::json& report);

/// {file, psnr_db, ssim, ...} a view.
nlohmann::json views_to_json(const Scores& scores);

/// A report as its file holds it; what is no UTF-8 (the name of a file) is replaced, not refused.
std::string to_text(const nlohmann::json& report);

}  // namespace sheen
