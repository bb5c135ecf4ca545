// SPDX-License-Identifier: Apache-2.0
#include "tracker/tracking_report.h"

#include <nlohmann/json.hpp>

#include "common/base/median.h"

namespace sheen {
namespace {

std::map<std::string, std::uint64_t> refusals(const TrackingReport& report) {
  std::map<std::string, std::uint64_t> refused = report.rig_refusals;
  for (const auto& [verdict, count] : report.verdicts)
    if (verdict != FrameVerdict::kKeyframe) refused[to_string(verdict)] = count;
  return refused;
}

}  // namespace

double TrackingReport::median_ms(const std::string& stage) const {
  const auto it = stage_ms.find(stage);
  return it == stage_ms.end() || it->second.empty() ? 0 : median(std::vector(it->second));
}

std::string TrackingReport::failure_text() const {
  if (!failure) return {};
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

std::string to_json(const TrackingReport& report, const std::map<std::string, std::uint64_t>& link) {
  nlohmann::json stages = nlohmann::json::object(), poses = nlohmann::json::object();
  for (const auto& [stage, times] : report.stage_ms) stages[stage] = report.median_ms(stage);
  for (const auto& [status, count] : report.poses) poses[to_string(status)] = count;
  const auto unacknowledged = link.find("unacknowledged");
  const std::uint64_t camera = report.grabbed + report.source.missed;
  const std::uint64_t lost = report.source.missed + report.overrun + report.unsent +
                             (unacknowledged == link.end() ? 0 : unacknowledged->second);
  const std::string failure = report.failure_text();
  const nlohmann::json document{{"frames",
                                 {{"camera", camera},
                                  {"received", camera - lost},
                                  {"lost", lost},
                                  {"grabbed", report.grabbed},
                                  {"missed", report.source.missed},
                                  {"overrun", report.overrun},
                                  {"sent", report.kept},
                                  {"live", report.live},
                                  {"unsent", report.unsent},
                                  {"refused", refusals(report)}}},
                                {"poses", poses},
                                {"source",
                                 {{"frames", report.source.frames},
                                  {"incomplete", report.source.incomplete},
                                  {"missed", report.source.missed},
                                  {"underruns", report.source.underruns},
                                  {"missing_packets", report.source.missing_packets},
                                  {"reopened", report.source.reopened},
                                  {"first_frame_id", report.source.first_frame_id},
                                  {"last_frame_id", report.source.last_frame_id}}},
                                {"stage_ms", stages},
                                {"link", link},
                                {"failure", failure.empty() ? nlohmann::json() : nlohmann::json(failure)}};
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

TrackerFrames frames_for_link(const TrackingReport& report) {
  return {.judged = report.judged, .refused = refusals(report), .trouble = report.trouble};
}

std::string summary(const TrackingReport& report) {
  std::string text = std::to_string(report.grabbed) + " frames, " + std::to_string(report.kept) + " keyframes sent";
  for (const auto& [reason, count] : refusals(report)) text += ", " + std::to_string(count) + " " + reason;
  if (report.source.missed) text += ", " + std::to_string(report.source.missed) + " never seen";
  if (report.overrun) text += ", " + std::to_string(report.overrun) + " overrun";
  if (report.unsent) text += ", " + std::to_string(report.unsent) + " unsent";
  return text;
}

}  // namespace sheen
