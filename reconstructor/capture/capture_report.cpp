// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/capture_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <variant>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/json_number.h"
#include "reconstructor/effort/resident_memory.h"
#include "reconstructor/evaluation/evaluation_report.h"

namespace sheen {
namespace {

using nlohmann::json;

json to_json(const SettingValue& value) {
  return std::visit(
      [](const auto& held) -> json {
        if constexpr (std::is_same_v<std::decay_t<decltype(held)>, std::monostate>)
          return nullptr;
        else
          return held;
      },
      value);
}

/// What was asked of the model, and whether it holds.
json settings_report(const Reconstruction& reconstruction, const Trade& trade, double psnr_db) {
  const std::unique_ptr<ModelSettings> settings = reconstruction.model().settings().clone();
  json report{{"model", settings->kind()},
              {"favour", trade.favour.empty() ? json() : json(trade.favour)},
              {"effort_level", trade.effort_level},
              {"effort_levels", trade.effort_levels},
              {"update_fraction", trade.update_fraction}};
  for (const SettingKey& key : settings->keys()) report[key.name] = to_json(key.get());
  if (trade.budget_ms)
    report["budget"] = {
        {"asked_ms", *trade.budget_ms}, {"image_ms", trade.image_ms}, {"holds", trade.image_ms <= *trade.budget_ms}};
  if (trade.memory_bytes)
    report["memory"] = {{"asked_bytes", *trade.memory_bytes},
                        {"bytes", trade.grown_bytes},
                        {"holds", trade.grown_bytes <= *trade.memory_bytes}};
  if (trade.target_db)
    report["target"] = {
        {"asked_db", *trade.target_db}, {"psnr_db", json_number(psnr_db)}, {"reached", psnr_db >= *trade.target_db}};
  return report;
}

/// What is held, by part, beside what the operating system says that the process has grown by.
json memory_report(const Reconstruction& reconstruction) {
  const MemoryAccount account = reconstruction.memory();
  const ResidentMemory resident = resident_memory();
  return {{"parts", account.parts()},
          {"counted_bytes", account.total()},
          {"resident_growth_bytes", reconstruction.resident_growth()},
          {"resident_bytes", resident.bytes},
          {"peak_resident_bytes", resident.peak_bytes}};
}

json tracker_report(const LinkState& tracker) {
  const ReceiverStats& link = tracker.stats;
  return {{"endpoint", tracker.endpoint},
          {"received", link.kept},
          {"duplicates", link.duplicates},
          {"lost", link.missing},
          {"judged", link.tracker.judged},
          {"refused", link.tracker.refused},
          {"failure", link.source_failure.empty() ? json() : json(link.source_failure)}};
}

/// A small file may happen to fit the held-out views better than what it was made of: that is no loss.
std::string lost_in_words(double loss_db) {
  return loss_db < 0.005 ? "nothing lost" : format("%.2f dB lost", loss_db);
}

}  // namespace

json reconstruction_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged) {
  const FrameCounts& counts = reconstruction.account().counts();
  json refused = json::object();
  for (const auto& [reason, n] : counts.refused) refused[reason] = n;
  json stages = json::object();
  for (const auto& [stage, seconds] : reconstruction.account().stages()) stages[stage] = 1e3 * seconds.median_s();

  json report;
  report["frames"] = {{"sent", counts.received},
                      {"received", counts.received},
                      {"accepted", counts.accepted},
                      {"held_out", counts.held_out},
                      {"refused", refused},
                      {"withdrawn", counts.withdrawn},
                      {"waiting", 0},
                      {"lost", 0}};
  report["ingest_images_per_s"] = reconstruction.account().images_per_s();
  report["ingest_ms"] = stages;
  const ModelFigures figures = reconstruction.model().figures();
  report["rank_histogram"] = figures.rank_histogram;
  report["bytes_per_patch"] = figures.bytes_per_patch;
  report["bytes_per_ring"] = figures.bytes_per_patch;  // its name when the parts of a model were rings: scripts read it
  const CaptureAccount::PatchCounts& patches = reconstruction.account().patches();
  report["patches"] = {{"updated", patches.updated}, {"skipped", patches.skipped}, {"left_out", patches.left_out}};
  const CaptureAccount::PhotometricCounts photometric = reconstruction.account().photometric();
  report["photometric"] = {{"response_measured", photometric.response},
                           {"vignette_measured", photometric.vignette},
                           {"not_measured", photometric.nothing}};
  report["memory"] = memory_report(reconstruction);
  const NumericalHealth health = reconstruction.health();
  report["settings"] = settings_report(reconstruction, reconstruction.trade(health), judged.model.psnr_db);
  report["numerics"] = {{"orthogonality_lost", json_number(health.orthogonality_lost)},
                        {"energy_lost", json_number(health.energy_lost)}};
  report["predicted_error"] = calibration_report(calibrate(judged.model));
  report["held_out"] = {{"views", judged.model.views.size()},
                        {"protocol", kScoreProtocol},
                        {"psnr_db", json_number(judged.model.psnr_db)},
                        {"ssim", json_number(judged.model.ssim)},
                        {"psnr_gain_aligned_db", json_number(judged.model.psnr_gain_aligned_db)},
                        {"psnr_pooled_db", json_number(judged.model.psnr_pooled_db)},
                        {"uncovered", json_number(judged.model.uncovered)},
                        {"constant_psnr_db", json_number(judged.constant.psnr_db)},
                        {"constant_ssim", json_number(judged.constant.ssim)},
                        {"constant_psnr_gain_aligned_db", json_number(judged.constant.psnr_gain_aligned_db)},
                        {"per_view", views_to_json(judged.model)},
                        {"constant_per_view", views_to_json(judged.constant)}};
  return report;
}

/// Null where nothing came, or the machines' clocks could not be compared.
json latency_report(const RunningStatistics& latency) {
  if (latency.count() == 0) return nullptr;
  const auto ms = [&](double q) { return 1e3 * latency.quantile_s(q); };
  return {{"p50", ms(0.50)}, {"p95", ms(0.95)}, {"p99", ms(0.99)}};
}

json live_report(const Reconstruction& reconstruction, const Reconstruction::Judgement& judged,
                 const LoopStatus& status) {
  json report = reconstruction_report(reconstruction, judged);
  const ReceiverStats link = status.link();
  report["frames"].update({{"sent", status.journaled + link.missing},
                           {"received", status.journaled},
                           {"waiting", status.waiting()},
                           {"lost", link.missing},
                           {"journaled", status.journaled},
                           {"duplicates", link.duplicates}});
  report["trackers"] = json::array();
  for (const LinkState& tracker : status.links) report["trackers"].push_back(tracker_report(tracker));
  report["latency_ms"] = latency_report(status.latency.to_disk);
  report["latency_to_model_ms"] = latency_report(status.latency.to_model);
  report["latency_to_picture_ms"] = latency_report(status.latency.to_picture);
  return report;
}

json files_report(const ImageAccount& account) {
  json left_out = json::array();
  for (const auto& [name, why, file] : account.left_out) left_out.push_back({{"name", name}, {"why", why}});
  return {{"images", account.images}, {"of", account.of},         {"masks", account.masks},
          {"left_out", left_out},     {"unused", account.unused}, {"grey", account.grey}};
}

json file_report(const std::filesystem::path& path, const SmallFile& file) {
  return {{"path", path.string()}, {"bytes", file.bytes}, {"loss_db", file.loss_db}, {"as_asked", file.as_asked}};
}

void print_summary(const json& report) {
  const auto withdrawn = report["frames"]["withdrawn"].get<unsigned long long>();
  if (const auto added = report["frames"]["accepted"].get<unsigned long long>(); added > 0)
    std::printf("%llu images added to the model at %.1f images/s", added, report["ingest_images_per_s"].get<double>());
  else
    std::printf("no image was added to the model");
  std::printf(", %llu held out", report["frames"]["held_out"].get<unsigned long long>());
  if (withdrawn > 0) std::printf(", %llu withdrawn", withdrawn);
  std::printf("\n");
  const json& held_out = report["held_out"];
  if (held_out["psnr_db"].is_number() && held_out["constant_psnr_db"].is_number())
    print_scores(held_out["psnr_db"].get<double>(), held_out["ssim"].get<double>(),
                 held_out["constant_psnr_db"].get<double>());
  if (const auto file = report.find("file"); file != report.end())
    std::printf("%s: %.3f MB, %s%s\n", file->at("path").get<std::string>().c_str(),
                1e-6 * file->at("bytes").get<double>(), lost_in_words(file->at("loss_db").get<double>()).c_str(),
                file->at("as_asked").get<bool>() ? "" : "; no file loses less");
}

}  // namespace sheen
