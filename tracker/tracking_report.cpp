// SPDX-License-Identifier: Apache-2.0
#include "tracker/tracking_report.h"

#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"

namespace sheen {
namespace {

using Counters = std::map<std::string, std::uint64_t>;

Counters refusals(const TrackingReport& report) {
  Counters refused = report.rig_refusals;
  for (const auto& [verdict, count] : report.verdicts)
    if (verdict != FrameVerdict::kKeyframe) refused[to_string(verdict)] = count;
  return refused;
}

template <typename Key>
void add(std::map<Key, std::uint64_t>& sum, const std::map<Key, std::uint64_t>& counts) {
  for (const auto& [key, count] : counts) sum[key] += count;
}

void add(TrackingReport& sum, const TrackingReport& report) {
  sum.grabbed += report.grabbed;
  sum.overrun += report.overrun;
  sum.judged += report.judged;
  sum.kept += report.kept;
  sum.unsent += report.unsent;
  sum.live += report.live;
  add(sum.verdicts, report.verdicts);
  add(sum.rig_refusals, report.rig_refusals);
  add(sum.poses, report.poses);
  sum.source.frames += report.source.frames;
  sum.source.incomplete += report.source.incomplete;
  sum.source.missed += report.source.missed;
  sum.source.underruns += report.source.underruns;
  sum.source.missing_packets += report.source.missing_packets;
  sum.source.foreign += report.source.foreign;
  sum.source.reopened += report.source.reopened;
  for (const auto& [stage, times] : report.stage_ms)
    sum.stage_ms[stage].insert(sum.stage_ms[stage].end(), times.begin(), times.end());
}

nlohmann::json frames_json(const TrackingReport& report, std::uint64_t unacknowledged) {
  const std::uint64_t camera = report.grabbed + report.source.missed;
  const std::uint64_t lost = report.source.missed + report.overrun + report.unsent + unacknowledged;
  return {{"camera", camera},
          {"received", camera - lost},
          {"lost", lost},
          {"grabbed", report.grabbed},
          {"missed", report.source.missed},
          {"overrun", report.overrun},
          {"sent", report.kept},
          {"live", report.live},
          {"unsent", report.unsent},
          {"refused", refusals(report)}};
}

nlohmann::json focal_json(const FocalWatch& focal) {
  return {{"images", focal.images()},
          {"deviation", focal.mean()},
          {"uncertainty", focal.sigma()},
          {"spread", focal.spread()},
          {"finding", focal.finding()}};
}

nlohmann::json report_json(const TrackingReport& report, std::uint64_t unacknowledged) {
  nlohmann::json stages = nlohmann::json::object(), poses = nlohmann::json::object();
  for (const auto& [stage, times] : report.stage_ms) stages[stage] = report.median_ms(stage);
  for (const auto& [status, count] : report.poses) poses[to_string(status)] = count;
  const std::string failure = report.failure_text();
  nlohmann::json document{{"frames", frames_json(report, unacknowledged)},
                          {"poses", poses},
                          {"source",
                           {{"frames", report.source.frames},
                            {"incomplete", report.source.incomplete},
                            {"missed", report.source.missed},
                            {"underruns", report.source.underruns},
                            {"missing_packets", report.source.missing_packets},
                            {"foreign", report.source.foreign},
                            {"reopened", report.source.reopened},
                            {"first_frame_id", report.source.first_frame_id},
                            {"last_frame_id", report.source.last_frame_id}}},
                          {"stage_ms", stages},
                          {"failure", failure.empty() ? nlohmann::json() : nlohmann::json(failure)}};
  if (report.focal.images() > 0) document["focal_length"] = focal_json(report.focal);
  return document;
}

std::string summary_of(const TrackingReport& report) {
  std::string text = std::to_string(report.grabbed) + " frames, " + std::to_string(report.kept) + " keyframes sent";
  for (const auto& [reason, count] : refusals(report)) text += ", " + std::to_string(count) + " " + reason;
  if (report.source.missed) text += ", " + std::to_string(report.source.missed) + " never seen";
  if (report.source.foreign) text += ", " + std::to_string(report.source.foreign) + " images of another camera";
  if (report.overrun) text += ", " + std::to_string(report.overrun) + " overrun";
  if (report.unsent) text += ", " + std::to_string(report.unsent) + " unsent";
  if (const std::string lens = report.focal.finding(); !lens.empty()) text += "; " + lens;
  return text;
}

/// "left: ...; right: ..." of the cameras that have such a text.
template <typename Text>
std::string by_camera(const RigReport& rig, const Text& text) {
  std::string all;
  for (const CameraReport& camera : rig)
    if (const std::string own = text(camera.report); !own.empty())
      all += (all.empty() ? "" : "; ") + (camera.name.empty() ? "" : camera.name + ": ") + own;
  return all;
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

TrackingReport total(const RigReport& rig) {
  if (rig.size() == 1 && rig.front().name.empty()) return rig.front().report;
  TrackingReport sum;
  for (const CameraReport& camera : rig) add(sum, camera.report);
  sum.trouble = by_camera(rig, [](const TrackingReport& report) { return report.trouble; });
  const std::string failure = by_camera(rig, [](const TrackingReport& report) { return report.failure_text(); });
  if (!failure.empty()) sum.failure = std::make_exception_ptr(Error(failure));
  return sum;
}

std::string to_json(const RigReport& rig, const Counters& link) {
  const auto unacknowledged = link.find("unacknowledged");
  nlohmann::json document = report_json(total(rig), unacknowledged == link.end() ? 0 : unacknowledged->second);
  document["link"] = link;
  for (const CameraReport& camera : rig)
    if (!camera.name.empty()) document["cameras"][camera.name] = report_json(camera.report, camera.unacknowledged);
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

TrackerFrames frames_for_link(const TrackingReport& report) {
  return {.judged = report.judged, .refused = refusals(report), .trouble = report.trouble};
}

std::string summary(const RigReport& rig) {
  std::string text = summary_of(total(rig));
  for (const CameraReport& camera : rig)
    if (!camera.name.empty()) text += "\n  " + camera.name + ": " + summary_of(camera.report);
  return text;
}

}  // namespace sheen
