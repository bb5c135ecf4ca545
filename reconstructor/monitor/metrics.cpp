// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/metrics.h"

#include <cmath>
#include <utility>

#include "common/base/format.h"

namespace sheen {
namespace {

using Labels = std::vector<std::pair<std::string, std::string>>;

std::string escaped_label(const std::string& value) {
  std::string out;
  for (const char c : value) {
    if (c == '\\' || c == '"') out += '\\';
    if (c == '\n')
      out += "\\n";
    else
      out += c;
  }
  return out;
}

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  return format("%.15g", value);
}

class Exposition {
 public:
  void family(const std::string& name, const char* type, const char* help) {
    name_ = "sheen_" + name;
    text_ += "# HELP " + name_ + " " + help + "\n# TYPE " + name_ + " " + type + "\n";
  }
  void sample(double value, const Labels& labels = {}, const char* suffix = "") {
    text_ += name_ + suffix;
    for (std::size_t i = 0; i < labels.size(); ++i)
      text_ += (i == 0 ? "{" : ",") + labels[i].first + "=\"" + escaped_label(labels[i].second) + "\"";
    text_ += (labels.empty() ? " " : "} ") + number(value) + "\n";
  }
  void single(const std::string& name, const char* type, const char* help, double value) {
    family(name, type, help);
    sample(value);
  }
  void summary(const std::string& name, const char* help, const DurationSummary& durations) {
    family(name, "summary", help);
    if (durations.count > 0) {
      sample(durations.p50_s, {{"quantile", "0.5"}});
      sample(durations.p95_s, {{"quantile", "0.95"}});
      sample(durations.p99_s, {{"quantile", "0.99"}});
    }
    sample(durations.sum_s, {}, "_sum");
    sample(static_cast<double>(durations.count), {}, "_count");
  }
  std::string take() { return std::move(text_); }

 private:
  std::string name_, text_;
};

void frames(const MonitorState& state, Exposition& out) {
  out.single("frames_received_total", "counter", "Captures that arrived to be kept.",
             static_cast<double>(state.received));
  out.single("frames_journaled_total", "counter", "Captures that are durable in the session.",
             static_cast<double>(state.journaled));
  out.single("frames_accepted_total", "counter", "Captures added to the model.", static_cast<double>(state.accepted));
  out.single("frames_held_out_total", "counter", "Captures held out to judge the model.",
             static_cast<double>(state.held_out));
  out.single("frames_withdrawn", "gauge", "Captures that were withdrawn.", static_cast<double>(state.withdrawn));
  out.single("frames_waiting", "gauge", "Captures that are durable and not in the model yet.",
             static_cast<double>(state.waiting));
  out.family("frames_rejected_total", "counter", "Captures that were not used, by reason.");
  for (const auto& [reason, n] : state.refused) out.sample(static_cast<double>(n), {{"reason", reason}});
  out.single("tracker_frames_total", "counter", "Frames of the camera that the tracker has judged.",
             static_cast<double>(state.tracker.judged));
  out.family("tracker_frames_refused_total", "counter",
             "Frames of the camera that the tracker did not keep, by reason.");
  for (const auto& [reason, n] : state.tracker.refused) out.sample(static_cast<double>(n), {{"reason", reason}});
  out.single("tracker_trouble", "gauge", "1 while the tracker refuses most frames.",
             state.tracker.trouble.empty() ? 0 : 1);
  out.single("sequence_gaps_total", "counter", "Captures that the tracker sent and nobody received.",
             static_cast<double>(state.sequence_gaps));
}

void speed(const MonitorState& state, Exposition& out) {
  out.single("ingest_images_per_second", "gauge", "Images that the model ingests per second.", state.images_per_s);
  out.summary("update_duration_seconds", "Time to add one image to the model.", state.update);
  out.summary("capture_latency_seconds", "Time from a frame's grabbing until it is durable.", state.latency);
  out.summary("model_latency_seconds", "Time from a frame's grabbing until it is in the model.", state.model_latency);
  out.summary("picture_latency_seconds", "Time from a frame's grabbing until a picture of the model contains it.",
              state.picture_latency);
  out.family("stage_duration_median_seconds", "gauge", "Median time per stage of an update.");
  for (const auto& [stage, seconds] : state.stage_s) out.sample(seconds, {{"stage", stage}});
  out.family("queue_depth", "gauge", "Captures that wait.");
  for (const auto& [name, queue] : state.queues) out.sample(static_cast<double>(queue.depth), {{"queue", name}});
  out.family("queue_capacity", "gauge", "Captures that may wait, where a queue has a limit.");
  for (const auto& [name, queue] : state.queues)
    if (queue.capacity > 0) out.sample(static_cast<double>(queue.capacity), {{"queue", name}});
}

void quality(const MonitorState& state, Exposition& out) {
  if (!state.held_out_curve.empty()) {
    const HeldOutPoint& last = state.held_out_curve.back();
    out.single("heldout_psnr_db", "gauge", "PSNR on object pixels of views that the model never saw.", last.psnr_db);
    out.single("heldout_ssim", "gauge", "SSIM on object pixels of views that the model never saw.", last.ssim);
    out.single("heldout_constant_psnr_db", "gauge", "The same PSNR for the mean colour of each surface sample.",
               last.constant_psnr_db);
  }
  out.family("patches", "gauge", "Patches of the model by the rank of their factorization.");
  for (std::size_t rank = 0; rank < state.rank_histogram.size(); ++rank)
    out.sample(static_cast<double>(state.rank_histogram[rank]), {{"rank", std::to_string(rank)}});
  out.single("model_bytes", "gauge", "Memory of the model.", static_cast<double>(state.model_bytes));
}

/// What was asked for and whether it is kept has a sample only where it was asked for.
void trade(const Trade& trade, Exposition& out) {
  out.single("effort_level", "gauge", "Effort level of the model: 0 is all that the settings ask for.",
             trade.effort_level);
  out.single("effort_levels", "gauge", "Effort levels that the model has.", trade.effort_levels);
  out.single("update_ratio", "gauge", "How much of what an image shows may be updated.", trade.update_fraction);
  if (trade.budget_ms)
    out.single("budget_seconds", "gauge", "Time per image that was asked for.", 1e-3 * *trade.budget_ms);
  if (trade.budget_kept())
    out.single("budget_kept", "gauge", "1 while the median image keeps the time asked for.", *trade.budget_kept());
  out.single("resident_memory_bytes", "gauge", "Resident memory of the process.", trade.resident_bytes);
  out.single("grown_memory_bytes", "gauge", "Resident memory by which the process has grown since there is a model.",
             trade.grown_bytes);
  if (trade.memory_bytes) out.single("memory_limit_bytes", "gauge", "Memory that was asked for.", *trade.memory_bytes);
  if (trade.memory_kept())
    out.single("memory_kept", "gauge", "1 while the memory grown is within what was asked for.", *trade.memory_kept());
  if (!std::isnan(trade.health.orthogonality_lost))
    out.single("orthogonality_loss", "gauge", "Largest entry of |B^T B - I| of the bases looked at.",
               trade.health.orthogonality_lost);
  if (!std::isnan(trade.health.energy_lost))
    out.single("energy_loss_ratio", "gauge", "Of the energy of all columns, the part that factorizations let go of.",
               trade.health.energy_lost);
}

void health(const MonitorState& state, CaptureState capture, MonitorState::Clock::time_point now, Exposition& out) {
  out.family("info", "gauge", "What runs here.");
  out.sample(1, {{"version", state.version}, {"model", state.model}, {"session", state.session_folder}});
  out.family("capture_state", "gauge", "1 for the state that the capture is in.");
  for (const CaptureState each :
       {CaptureState::kWaiting, CaptureState::kLive, CaptureState::kStale, CaptureState::kDisconnected,
        CaptureState::kEnded, CaptureState::kFinishing, CaptureState::kRefining, CaptureState::kSaving,
        CaptureState::kJudging, CaptureState::kFailed, CaptureState::kStalled})
    out.sample(each == capture ? 1 : 0, {{"state", to_string(each)}});
  if (state.ending && state.ending->total > 0)
    out.single("ending_progress_ratio", "gauge", "How much of finishing, refining, saving or judging is done.",
               static_cast<double>(state.ending->done) / static_cast<double>(state.ending->total));
  out.family("link_connected", "gauge", "1 where the peer is connected.");
  for (const MonitorState::Link& link : state.links)
    out.sample(link.connected ? 1 : 0, {{"link", link.name}, {"endpoint", link.endpoint}});
  if (state.last_frame)
    out.single("last_frame_age_seconds", "gauge", "Time since a capture arrived.",
               std::chrono::duration<double>(now - *state.last_frame).count());
}

}  // namespace

std::string metrics_text(const MonitorState& state, CaptureState capture, MonitorState::Clock::time_point now) {
  Exposition out;
  health(state, capture, now, out);
  frames(state, out);
  speed(state, out);
  quality(state, out);
  trade(state.trade, out);
  return out.take();
}

}  // namespace sheen
