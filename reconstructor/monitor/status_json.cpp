// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/status_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/base/json_number.h"

namespace sheen {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kCurvePoints = 400;

Json to_json(const DurationSummary& durations) {
  Json json = {{"count", durations.count}};
  if (durations.count > 0)
    json.update({{"p50", json_number(durations.p50_s)},
                 {"p95", json_number(durations.p95_s)},
                 {"p99", json_number(durations.p99_s)}});
  return json;
}

/// Null where something was not asked for, or is not known yet.
template <typename T>
Json asked(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json to_json(const Trade& trade) {
  return {{"favour", trade.favour.empty() ? Json() : Json(trade.favour)},
          {"effort_level", trade.effort_level},
          {"effort_levels", trade.effort_levels},
          {"update_fraction", trade.update_fraction},
          {"image_s", trade.image_ms > 0 ? Json(1e-3 * trade.image_ms) : Json()},
          {"budget_s", trade.budget_ms ? Json(1e-3 * *trade.budget_ms) : Json()},
          {"budget_kept", asked(trade.budget_kept())},
          {"resident_bytes", trade.resident_bytes},
          {"grown_bytes", trade.grown_bytes},
          {"memory_bytes", asked(trade.memory_bytes)},
          {"memory_kept", asked(trade.memory_kept())},
          {"target_db", asked(trade.target_db)},
          {"orthogonality_lost", json_number(trade.health.orthogonality_lost)},
          {"energy_lost", json_number(trade.health.energy_lost)}};
}

Json curve_to_json(const std::vector<HeldOutPoint>& curve) {
  const std::size_t step = curve.size() / kCurvePoints + 1;
  Json json = Json::array();
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if ((curve.size() - 1 - i) % step != 0) continue;
    json.push_back({{"images", curve[i].images},
                    {"psnr_db", json_number(curve[i].psnr_db)},
                    {"ssim", json_number(curve[i].ssim)},
                    {"constant_psnr_db", json_number(curve[i].constant_psnr_db)}});
  }
  return json;
}

}  // namespace

std::string status_json(const MonitorState& state, CaptureState capture, double published_age_s, double frame_age_s,
                        const PictureVersions& pictures, bool may_steer) {
  Json json = {{"role", "reconstructor"},
               {"version", state.version},
               {"state", to_string(capture)},
               {"error", state.error},
               {"warnings", state.warnings},
               {"model", state.model},
               {"model_reason", state.model_reason},
               {"session_folder", state.session_folder},
               {"source_session", state.source_session},
               {"photometric", state.photometric},
               {"published_age_s", json_number(published_age_s)},
               {"frame_age_s", json_number(frame_age_s)},
               {"next_view", state.next_view},
               {"well_known", state.well_known},
               {"paused", state.paused},
               {"steering", state.steering},
               {"may_steer", may_steer},
               {"hint", state.hint},
               {"doing", state.doing}};
  json["links"] = Json::array();
  for (const MonitorState::Link& link : state.links)
    json["links"].push_back({{"name", link.name},
                             {"endpoint", link.endpoint},
                             {"connected", link.connected},
                             {"encrypted", link.encrypted},
                             {"came", link.came},
                             {"ended", link.ended},
                             {"last_error", link.last_error}});
  json["ending"] = nullptr;
  if (state.ending) json["ending"] = {{"done", state.ending->done}, {"total", state.ending->total}};
  json["frames"] = {{"received", state.received}, {"journaled", state.journaled},        {"accepted", state.accepted},
                    {"held_out", state.held_out}, {"withdrawn", state.withdrawn},        {"waiting", state.waiting},
                    {"refused", state.refused},   {"sequence_gaps", state.sequence_gaps}};
  json["tracker"] = {
      {"judged", state.tracker.judged}, {"refused", state.tracker.refused}, {"trouble", state.tracker.trouble}};
  json["ingest_images_per_s"] = json_number(state.images_per_s);
  json["update_s"] = to_json(state.update);
  json["latency_s"] = to_json(state.latency);
  json["model_latency_s"] = to_json(state.model_latency);
  json["picture_latency_s"] = to_json(state.picture_latency);
  json["stage_s"] = Json::object();
  for (const auto& [stage, seconds] : state.stage_s) json["stage_s"][stage] = json_number(seconds);
  json["queues"] = Json::object();
  for (const auto& [name, queue] : state.queues)
    json["queues"][name] = {{"depth", queue.depth}, {"capacity", queue.capacity}};
  json["rank_histogram"] = state.rank_histogram;
  json["surface"] = nullptr;
  if (state.surface) json["surface"] = {{"seen", state.surface->seen}, {"measured", state.surface->measured}};
  json["shape"] = nullptr;
  if (state.shape)
    json["shape"] = {
        {"seen", state.shape->seen}, {"outlined", state.shape->outlined}, {"guessed", state.shape->guessed}};
  json["model_bytes"] = state.model_bytes;
  json["trade"] = to_json(state.trade);
  json["held_out_curve"] = curve_to_json(state.held_out_curve);
  json["pictures"] = {{"preview", pictures.preview},
                      {"preview_note", state.preview_note},
                      {"shape", pictures.shape},
                      {"camera", pictures.camera},
                      {"model_page", pictures.model_page}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace sheen
