// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/report/report.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"

namespace sheen {
namespace {

using nlohmann::json;

constexpr const char* kProtocol =
    "object pixels: first hit a front face, inside the mask or eroded by 3 px without one; 8-bit sRGB; mean over views";

/// JSON has no infinity and no NaN.
json number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json means_to_json(const Scores& s) {
  return {{"psnr_db", number(s.psnr_db)},
          {"ssim", number(s.ssim)},
          {"psnr_inside_db", number(s.psnr_inside_db)},
          {"psnr_pooled_db", number(s.psnr_pooled_db)},
          {"psnr_gain_aligned_db", number(s.psnr_gain_aligned_db)}};
}

json calibration_to_json(const ErrorCalibration& calibration) {
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

}  // namespace

json views_to_json(const Scores& scores) {
  json views = json::array();
  for (const ViewScore& v : scores.views)
    views.push_back({{"file", v.name},
                     {"psnr_db", number(v.psnr_db)},
                     {"ssim", number(v.ssim)},
                     {"psnr_gain_aligned_db", number(v.psnr_gain_aligned_db)},
                     {"uncovered", number(v.uncovered)}});
  return views;
}

/// What was asked of the model, and whether it holds.
json settings_report(const Reconstruction& reconstruction, double psnr_db) {
  const TradeoffWish& wish = reconstruction.wish();
  const SurfaceLightFieldOptions& options = reconstruction.model().options();
  json report{{"map_scale", options.map_scale},
              {"max_rank", options.ring.factor.max_rank},
              {"tolerance", options.ring.factor.tolerance},
              {"sampling", options.sampling == Sampling::kCubic ? "cubic" : "linear"},
              {"rung", reconstruction.effort().rung},
              {"share", reconstruction.effort().share}};
  if (wish.image_ms) {
    const double image_ms = 1e3 * reconstruction.updates().median_s();
    report["budget"] = {{"asked_ms", *wish.image_ms}, {"image_ms", image_ms}, {"holds", image_ms <= *wish.image_ms}};
  }
  if (wish.bytes) {
    const double grown = resident_memory().bytes - reconstruction.resident_before();
    report["memory"] = {{"asked_bytes", *wish.bytes}, {"bytes", grown}, {"holds", grown <= *wish.bytes}};
  }
  if (wish.psnr_db)
    report["target"] = {
        {"asked_db", *wish.psnr_db}, {"psnr_db", number(psnr_db)}, {"reached", psnr_db >= *wish.psnr_db}};
  return report;
}

/// What is held, by part, beside what the operating system says that the process has grown by.
json memory_report(const Reconstruction& reconstruction) {
  const MemoryAccount account = reconstruction.memory();
  const ResidentMemory resident = resident_memory();
  return {{"parts", account.parts()},
          {"counted_bytes", account.total()},
          {"resident_growth_bytes", resident.bytes - reconstruction.resident_before()},
          {"resident_bytes", resident.bytes},
          {"peak_resident_bytes", resident.peak_bytes}};
}

json reconstruction_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged) {
  const FrameCounts& counts = reconstruction.counts();
  json refused = json::object();
  for (const auto& [reason, n] : counts.refused) refused[reason] = n;
  json stages = json::object();
  for (const auto& [stage, seconds] : reconstruction.stages()) stages[stage] = 1e3 * seconds.median_s();

  json report;
  report["frames"] = {{"sent", counts.received},
                      {"received", counts.received},
                      {"accepted", counts.accepted},
                      {"held_out", counts.held_out},
                      {"refused", refused},
                      {"withdrawn", counts.withdrawn},
                      {"waiting", 0},
                      {"lost", 0}};
  report["ingest_images_per_s"] = reconstruction.images_per_s();
  report["ingest_ms"] = stages;
  report["rank_histogram"] = reconstruction.model().rank_histogram();
  report["bytes_per_ring"] = reconstruction.model().bytes_per_ring();
  const Reconstruction::RingCounts& rings = reconstruction.rings();
  report["rings"] = {{"updated", rings.updated}, {"skipped", rings.skipped}, {"left_out", rings.left_out}};
  report["memory"] = memory_report(reconstruction);
  report["settings"] = settings_report(reconstruction, judged.light_field.psnr_db);
  report["predicted_error"] = calibration_to_json(calibrate(judged.light_field));
  report["held_out"] = {{"views", judged.light_field.views.size()},
                        {"protocol", kProtocol},
                        {"psnr_db", number(judged.light_field.psnr_db)},
                        {"ssim", number(judged.light_field.ssim)},
                        {"psnr_gain_aligned_db", number(judged.light_field.psnr_gain_aligned_db)},
                        {"psnr_pooled_db", number(judged.light_field.psnr_pooled_db)},
                        {"uncovered", number(judged.light_field.uncovered)},
                        {"constant_psnr_db", number(judged.constant.psnr_db)},
                        {"constant_ssim", number(judged.constant.ssim)},
                        {"constant_psnr_gain_aligned_db", number(judged.constant.psnr_gain_aligned_db)},
                        {"per_view", views_to_json(judged.light_field)},
                        {"constant_per_view", views_to_json(judged.constant)}};
  return report;
}

json live_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged,
                 const LoopStatus& status) {
  json report = reconstruction_report(reconstruction, judged);
  report["frames"].update({{"sent", status.journaled + status.link.missing},
                           {"received", status.journaled},
                           {"waiting", status.waiting()},
                           {"lost", status.link.missing},
                           {"journaled", status.journaled},
                           {"duplicates", status.link.duplicates}});
  const auto ms = [&](double q) { return 1e3 * status.latency.quantile_s(q); };
  report["latency_ms"] = nullptr;  // nothing came, or the machines' clocks could not be compared
  if (status.latency.count() > 0) report["latency_ms"] = {{"p50", ms(0.50)}, {"p95", ms(0.95)}, {"p99", ms(0.99)}};
  return report;
}

json evaluation_report(const Scores& light_field, const Scores& constant) {
  return {{"protocol", kProtocol},
          {"object", means_to_json(light_field)},
          {"full", {{"psnr_db", number(light_field.full_psnr_db)}, {"ssim", number(light_field.full_ssim)}}},
          {"constant", means_to_json(constant)},
          {"uncovered", number(light_field.uncovered)},
          {"views", views_to_json(light_field)},
          {"constant_views", views_to_json(constant)}};
}

json baselines_report(const BaselineScores& baselines) {
  json report;
  for (const auto& [name, scores] : {std::pair{"constant_colour", &baselines.constant_colour},
                                     std::pair{"nearest_photograph", &baselines.nearest_photograph},
                                     std::pair{"unstructured_lumigraph", &baselines.unstructured_lumigraph}}) {
    report[name] = means_to_json(*scores);
    report[name]["views"] = views_to_json(*scores);
  }
  return report;
}

void print_baselines(const Scores& light_field, const BaselineScores& baselines) {
  std::printf("%-46s %8s %6s %9s %14s\n", "held-out views, object pixels", "PSNR", "SSIM", "inside", "gain-aligned");
  const auto line = [](const char* name, const Scores& s) {
    std::printf("%-46s %5.2f dB %6.3f %6.2f dB %11.2f dB\n", name, s.psnr_db, s.ssim, s.psnr_inside_db,
                s.psnr_gain_aligned_db);
  };
  const Scores& lumigraph = baselines.unstructured_lumigraph;
  line("constant colour", baselines.constant_colour);
  line("nearest photograph (all kept)", baselines.nearest_photograph);
  line("unstructured lumigraph (4 nearest, all kept)", lumigraph);
  line("surface light field (no photograph kept)", light_field);
  std::printf("%-46s %+5.2f dB %+6.3f %+6.2f dB %+11.2f dB\n", "  above the unstructured lumigraph",
              light_field.psnr_db - lumigraph.psnr_db, light_field.ssim - lumigraph.ssim,
              light_field.psnr_inside_db - lumigraph.psnr_inside_db,
              light_field.psnr_gain_aligned_db - lumigraph.psnr_gain_aligned_db);
}

json foretelling_report(const Foretelling& foretelling) {
  return {{"rank_correlation", number(foretelling.rank_correlation)},
          {"paper_rank_correlation", number(foretelling.paper_rank_correlation)}};
}

json prediction_report(const Scores& scores) {
  const CalibrationCheck check = check_calibration(scores);
  json report = {{"predicted_db", number(check.predicted_db)},
                 {"calibrated_db", number(check.calibrated_db)},
                 {"measured_db", number(check.measured_db)},
                 {"coverage", number(check.coverage)},
                 {"calibration", calibration_to_json(calibrate(scores))},
                 {"views", json::array()}};
  for (const PredictedView& view : check.views) {
    const CalibratedPsnr calibrated = view.calibrated();
    report["views"].push_back({{"file", scores.views[view.index].name},
                               {"predicted_db", view.predicted_db},
                               {"calibrated_db", number(calibrated.db)},
                               {"low_db", number(calibrated.low_db)},
                               {"high_db", number(calibrated.high_db)},
                               {"measured_db", view.measured_db}});
  }
  return report;
}

void print_predictions(const Scores& scores, const Foretelling& foretelling) {
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
        "dB; %.0f %% of the %zu views lie in their %.0f %% intervals\n"
        "calibration by all: %+.2f dB, %.0f %% of such views within %.2f dB of that\n",
        check.predicted_db, check.calibrated_db, check.measured_db, 100 * check.coverage, check.views.size(), kPercent,
        all.offset_db, kPercent, all.half_width_db);
  } else {
    std::printf(
        "predicted PSNR inside the object's edge: %.2f dB, not calibrated (needs %zu held-out views, there are %zu); "
        "measured %.2f dB\n",
        check.predicted_db, ErrorCalibration::kFewestViews + 1, check.views.size(), check.measured_db);
  }
  std::printf("rank correlation of predicted and measured errors of triangles: %.2f (the paper's heuristic: %.2f)\n",
              foretelling.rank_correlation, foretelling.paper_rank_correlation);
}

void print_summary(const json& report) {
  const bool built = report.contains("held_out");
  const json& model = built ? report["held_out"] : report["object"];
  const json& constant_psnr = built ? report["held_out"]["constant_psnr_db"] : report["constant"]["psnr_db"];
  if (built) {
    const auto withdrawn = report["frames"]["withdrawn"].get<unsigned long long>();
    std::printf("%llu images folded in at %.1f images/s, %llu held out",
                report["frames"]["accepted"].get<unsigned long long>(), report["ingest_images_per_s"].get<double>(),
                report["frames"]["held_out"].get<unsigned long long>());
    if (withdrawn > 0) std::printf(", %llu withdrawn", withdrawn);
    std::printf("\n");
  }
  if (model["psnr_db"].is_number() && constant_psnr.is_number())
    std::printf("held-out views, object pixels: PSNR %.2f dB, SSIM %.3f (constant colour: %.2f dB)\n",
                model["psnr_db"].get<double>(), model["ssim"].get<double>(), constant_psnr.get<double>());
}

std::string to_text(const json& document) {
  return document.dump(2, ' ', false, json::error_handler_t::replace) + '\n';
}

}  // namespace sheen
