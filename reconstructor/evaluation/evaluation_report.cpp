// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/evaluation/evaluation_report.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/format.h"
#include "common/base/json_number.h"

namespace sheen {
namespace {

using nlohmann::json;

json means_to_json(const Scores& s) {
  return {{"psnr_db", json_number(s.psnr_db)},
          {"ssim", json_number(s.ssim)},
          {"psnr_inside_db", json_number(s.psnr_inside_db)},
          {"psnr_pooled_db", json_number(s.psnr_pooled_db)},
          {"psnr_gain_aligned_db", json_number(s.psnr_gain_aligned_db)}};
}

constexpr double kPredictionsFail_db = 10;  // off by more, they predict nothing

std::string shown(double value) {
  return std::isfinite(value) ? format("%.2f", value) : "-";
}

}  // namespace

json views_to_json(const Scores& scores) {
  json views = json::array();
  for (const ViewScore& v : scores.views)
    views.push_back({{"file", v.name},
                     {"source_session", v.source_session},
                     {"sequence", v.sequence},
                     {"psnr_db", json_number(v.psnr_db)},
                     {"ssim", json_number(v.ssim)},
                     {"psnr_gain_aligned_db", json_number(v.psnr_gain_aligned_db)},
                     {"uncovered", json_number(v.uncovered)}});
  return views;
}

json evaluation_report(const Scores& model, const Scores& constant) {
  return {{"protocol", kScoreProtocol},
          {"object", means_to_json(model)},
          {"full", {{"psnr_db", json_number(model.full_psnr_db)}, {"ssim", json_number(model.full_ssim)}}},
          {"constant", means_to_json(constant)},
          {"uncovered", json_number(model.uncovered)},
          {"views", views_to_json(model)},
          {"constant_views", views_to_json(constant)}};
}

json baselines_report(std::span<const BaselineScores> baselines) {
  json report;
  for (const auto& [baseline, scores] : baselines) {
    report[baseline.key] = means_to_json(scores);
    report[baseline.key]["views"] = views_to_json(scores);
    report[baseline.key]["bytes"] = bytes_report(baseline);
  }
  return report;
}

json bytes_report(const Baseline& baseline) {
  return {{"disk", baseline.disk_bytes}, {"memory", baseline.memory_bytes}};
}

void print_baselines(std::span<const BaselineScores> baselines, const BaselineScores& model) {
  std::printf("%-46s %8s %6s %9s %14s %9s %9s\n", "held-out views, object pixels", "PSNR", "SSIM", "inside",
              "gain-aligned", "file MB", "memory MB");
  const auto line = [](const BaselineScores& of) {
    const Scores& s = of.scores;
    std::printf("%-46s %5.2f dB %6.3f %6.2f dB %11.2f dB %9.2f %9.2f\n", of.baseline.title.c_str(), s.psnr_db, s.ssim,
                s.psnr_inside_db, s.psnr_gain_aligned_db, 1e-6 * of.baseline.disk_bytes,
                1e-6 * of.baseline.memory_bytes);
  };
  for (const BaselineScores& baseline : baselines) line(baseline);
  line(model);
  for (const auto& [baseline, scores] : baselines) {
    if (baseline.disk_bytes == 0) continue;  // keeps no photographs
    std::printf("  above the %-34s %+5.2f dB %+6.3f %+6.2f dB %+11.2f dB\n",
                baseline.title.substr(0, baseline.title.find(" (")).c_str(), model.scores.psnr_db - scores.psnr_db,
                model.scores.ssim - scores.ssim, model.scores.psnr_inside_db - scores.psnr_inside_db,
                model.scores.psnr_gain_aligned_db - scores.psnr_gain_aligned_db);
  }
}

json ranking_report(const ErrorRanking& ranking) {
  return {{"rank_correlation", json_number(ranking.rank_correlation)},
          {"peer_rank_correlation", json_number(ranking.other_rank_correlation)}};
}

json calibration_report(const ErrorCalibration& calibration) {
  if (!calibration.known())
    return {{"calibrated", false},
            {"views", calibration.views},
            {"fewest_views", static_cast<std::size_t>(ErrorCalibration::kFewestViews)}};
  return {{"calibrated", true},
          {"views", calibration.views},
          {"offset_db", calibration.offset_db},
          {"half_width_db", calibration.half_width_db},
          {"holds", double(ErrorCalibration::kCoverage)}};
}

json prediction_report(const Scores& scores) {
  const CalibrationCheck check = check_calibration(scores);
  json report = {
      {"predicted_db", json_number(check.predicted_db)},      {"calibrated_db", json_number(check.calibrated_db)},
      {"measured_db", json_number(check.measured_db)},        {"coverage", json_number(check.coverage)},
      {"calibration", calibration_report(calibrate(scores))}, {"views", json::array()}};
  for (const PredictedView& view : check.views) {
    const CalibratedPsnr calibrated = view.calibrated();
    report["views"].push_back({{"file", scores.views[view.index].name},
                               {"predicted_db", view.predicted_db},
                               {"calibrated_db", json_number(calibrated.db)},
                               {"low_db", json_number(calibrated.low_db)},
                               {"high_db", json_number(calibrated.high_db)},
                               {"measured_db", view.measured_db}});
  }
  return report;
}

void print_predictions(const Scores& scores, const ErrorRanking& ranking, const std::string& peer_title) {
  const CalibrationCheck check = check_calibration(scores);
  const ErrorCalibration all = calibrate(scores);
  constexpr double kPercent = 100 * ErrorCalibration::kCoverage;
  if (check.known()) {
    for (const PredictedView& view : check.views) {
      const CalibratedPsnr calibrated = view.calibrated();
      std::printf("  %s: predicted %.2f dB, calibrated %.2f [%.2f, %.2f] dB, measured %.2f dB%s\n",
                  scores.views[view.index].name.c_str(), view.predicted_db, calibrated.db, calibrated.low_db,
                  calibrated.high_db, view.measured_db, view.inside() ? "" : ": outside");
    }
    std::printf(
        "predicted PSNR inside the object's edge: %.2f dB, calibrated (each view by the others) %.2f dB, measured %.2f "
        "dB; %.0f %% of the %zu views lie in their %.0f %% intervals\n",
        check.predicted_db, check.calibrated_db, check.measured_db, 100 * check.coverage, check.views.size(), kPercent);
    if (std::abs(all.offset_db) > kPredictionsFail_db)
      std::printf("predictions are of no use here: they are off by %.0f dB\n", std::abs(all.offset_db));
    else
      std::printf(
          "by all views, what is measured is %.2f dB %s than predicted, %.0f %% of them within %.2f dB of that\n",
          std::abs(all.offset_db), all.offset_db < 0 ? "less" : "more", kPercent, all.half_width_db);
  } else {
    std::printf(
        "predicted PSNR inside the object's edge: %s dB, not calibrated (needs %zu held-out views, there are %zu); "
        "measured %s dB\n",
        shown(check.predicted_db).c_str(), ErrorCalibration::kFewestViews + 1, check.views.size(),
        shown(check.measured_db).c_str());
  }
  if (std::isfinite(ranking.rank_correlation))
    std::printf("rank correlation of predicted and measured errors of triangles: %.2f (%s: %s)\n",
                ranking.rank_correlation, peer_title.c_str(), shown(ranking.other_rank_correlation).c_str());
}

void print_scores(double psnr_db, double ssim, double constant_psnr_db) {
  std::printf("held-out views, object pixels: PSNR %.2f dB, SSIM %.3f (constant colour: %.2f dB)\n", psnr_db, ssim,
              constant_psnr_db);
}

std::string to_text(const json& document) {
  return document.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
}

}  // namespace sheen
