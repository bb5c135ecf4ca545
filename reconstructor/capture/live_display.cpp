// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/capture/live_display.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/base/format.h"
#include "common/capture/linear_capture.h"
#include "reconstructor/capture/preview_pictures.h"
#include "reconstructor/render/guidance.h"
#include "reconstructor/render/nearest_photograph.h"

namespace sheen {
namespace {

constexpr std::chrono::seconds kTurn{3};    ///< for which one of several cameras is shown
constexpr double kFewWait = 3, kLag_s = 1;  ///< images that may wait, or as many as are added in this time
constexpr double kSameView = 0.94;          ///< cosine of 20 degrees
constexpr int kInsists = 8;                 ///< snapshots in a row

TrackerLink link_of(const ReceiverStats& link, const EndProgress& end,
                    const std::optional<MonitorState::Clock::time_point>& last) {
  if (link.ended || end.stage != EndStage::kCapturing) return TrackerLink::kEnded;
  if (!last) return TrackerLink::kWaiting;
  const bool fresh = MonitorState::Clock::now() - *last < kStaleAfter;
  return link.connected && fresh ? TrackerLink::kConnected : TrackerLink::kStale;
}

/// What starts the trackers that have not come yet.
std::string commands_for_missing(const std::vector<LiveDisplay::Names::Tracker>& trackers,
                                 const std::vector<LinkState>& links) {
  std::string commands;
  for (std::size_t i = 0; i < trackers.size(); ++i)
    if (i >= links.size() || !links[i].stats.came) commands += (commands.empty() ? "" : " and ") + trackers[i].command;
  return commands;
}

std::string message_of(const LoopStatus& status, const ReceiverStats& link, const std::string& missing) {
  if (!status.error.empty()) return status.error;
  if (status.rebuild_until > 0)
    return std::string(status.on_another_mesh ? "on the better mesh" : "without what was taken back") + ": image " +
           std::to_string(status.ingested) + " of " + std::to_string(status.rebuild_until);
  if (!link.ended && link.last_error.empty() && !missing.empty()) return "start a tracker: " + missing;
  return link.last_error;
}

std::string text_of(const MeshLook& look) {
  return "improving the mesh with " + std::to_string(look.captures) + " images: step " + std::to_string(look.done) +
         " of " + std::to_string(look.steps);
}

/// What the tracker finds wrong with what the camera sees now.
std::string trouble_of(const ReceiverStats& link, const EndProgress& end) {
  const bool running = link.connected && !link.ended && end.stage == EndStage::kCapturing;
  return running ? link.tracker.trouble : "";
}

std::vector<MonitorState::Link> links_of(const LiveDisplay::Names& names, const std::vector<LinkState>& links) {
  std::vector<MonitorState::Link> shown;
  for (std::size_t i = 0; i < names.trackers.size(); ++i) {
    const ReceiverStats link = i < links.size() ? links[i].stats : ReceiverStats{};
    shown.push_back({.name = names.trackers.size() == 1 ? "tracker" : "tracker " + std::to_string(i + 1),
                     .endpoint = names.trackers[i].endpoint,
                     .connected = link.connected,
                     .encrypted = names.encrypted,
                     .last_error = link.last_error,
                     .came = link.came,
                     .ended = link.ended});
  }
  return shown;
}

/// Whether two captures are of the same camera, as far as they tell.
bool same_source(const Capture& a, const Capture& b) {
  return a.source_session == b.source_session && a.calibration_hash == b.calibration_hash;
}

/// Nothing of a mesh that was given.
std::optional<MonitorState::Shape> shape_of(const Mesh& mesh) {
  if (mesh.evidence.empty()) return std::nullopt;
  return MonitorState::Shape{.seen = share_known_as(ShapeEvidence::kSeen, mesh),
                             .outlined = share_known_as(ShapeEvidence::kOutline, mesh),
                             .guessed = share_known_as(ShapeEvidence::kGuessed, mesh)};
}

/// What the model has to say of the next view is old while images wait.
bool lags(const LoopStatus& status) {
  return static_cast<double>(status.waiting()) > std::max(kFewWait, status.images_per_s * kLag_s);
}

std::optional<WorkInHand> work_of(const EndProgress& end) {
  const auto done = [&end](std::string text, const char* of) {
    if (end.total > 0)
      text += std::string(": ") + of + " " + std::to_string(end.done) + " of " + std::to_string(end.total);
    return text;
  };
  constexpr const char* kNoModel = "Q: end now, without the model; the images are kept";
  constexpr const char* kNoReport = "the model is saved; Q: end now, without the report";
  const double fraction = end.total > 0 ? static_cast<double>(end.done) / static_cast<double>(end.total) : 0;
  switch (end.stage) {
    case EndStage::kCapturing:
      break;
    case EndStage::kFinishing:
      return WorkInHand{done("The last images are being added", "image"), fraction, kNoModel};
    case EndStage::kRefining:
      return WorkInHand{done("The mesh is being improved a last time", "step"), fraction, kNoModel};
    case EndStage::kSaving:
      return WorkInHand{done("The model is being saved", "part"), fraction, kNoModel};
    case EndStage::kJudging:
      return WorkInHand{done("The model is compared with the views kept aside", "picture"), fraction, kNoReport};
  }
  return std::nullopt;
}

std::optional<MonitorState::Ending> ending_of(const EndProgress& end) {
  switch (end.stage) {
    case EndStage::kCapturing:
      break;
    case EndStage::kFinishing:
      return MonitorState::Ending{CaptureState::kFinishing, end.done, end.total};
    case EndStage::kRefining:
      return MonitorState::Ending{CaptureState::kRefining, end.done, end.total};
    case EndStage::kSaving:
      return MonitorState::Ending{CaptureState::kSaving, end.done, end.total};
    case EndStage::kJudging:
      return MonitorState::Ending{CaptureState::kJudging, end.done, end.total};
  }
  return std::nullopt;
}

}  // namespace

LoopObserver LiveDisplay::observer() {
  return {.on_snapshot =
              [this](std::shared_ptr<const ModelSnapshot> snapshot, std::shared_ptr<const RayPainter> painter) {
                const std::lock_guard lock(mutex_);
                latest_.snapshot = std::move(snapshot);
                latest_.painter = std::move(painter);
                ++latest_.number;
              },
          .on_capture =
              [this](const Capture& capture) {
                if (!takes_turn(capture)) return;
                auto copy = std::make_shared<const Capture>(capture);
                const std::lock_guard lock(mutex_);
                latest_.capture = std::move(copy);
              }};
}

/// Whether it is of the camera that is shown now; each has a while, for a picture that flickers is none.
bool LiveDisplay::takes_turn(const Capture& capture) {
  const auto now = MonitorState::Clock::now();
  const std::lock_guard lock(mutex_);
  latest_.capture_at = now;
  if (latest_.capture && same_source(*latest_.capture, capture)) return true;
  if (latest_.capture && now - turn_began_ < kTurn) return false;
  turn_began_ = now;
  return true;
}

void LiveDisplay::warn(const std::string& warning) {
  const std::lock_guard lock(mutex_);
  latest_.warnings.push_back(warning);
}

LiveDisplay::Latest LiveDisplay::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

void LiveDisplay::publish_to_window(const LoopStatus& status, const EndProgress& end) {
  const Latest now = latest();
  update_next_view(now);
  const ReceiverStats stats = status.link();
  CaptureFigures figures{.frames_received = status.journaled,
                         .frames_accepted = status.counts.accepted + status.counts.held_out,
                         .frames_held_out = status.counts.held_out,
                         .frames_refused = status.counts.refused,
                         .frames_withdrawn = status.counts.withdrawn,
                         .frames_waiting = status.waiting(),
                         .tracker_judged = stats.tracker.judged,
                         .tracker_refused = stats.tracker.refused,
                         .images_per_s = status.images_per_s,
                         .trade = status.trade};
  if (status.counts.accepted > 0) figures.residual = status.last.relative_residual;
  if (std::isfinite(status.last.predicted_psnr_db)) figures.predicted_psnr_db = status.last.predicted_psnr_db;
  if (!status.held_out_curve.empty()) {
    figures.held_out_psnr_db = status.held_out_curve.back().psnr_db;
    figures.held_out_ssim = status.held_out_curve.back().ssim;
  }
  const bool capturing = end.stage == EndStage::kCapturing;
  std::string message = message_of(status, stats, capturing ? commands_for_missing(names_.trackers, status.links) : "");
  if (message.empty() && !now.warnings.empty()) message = now.warnings.front();
  if (message.empty() && status.mesh_look) message = text_of(*status.mesh_look);
  feed_.publish({.snapshot = now.snapshot,
                 .capture = now.capture,
                 .figures = figures,
                 .link = link_of(stats, end, now.capture_at),
                 .next_view = lags(status) ? std::nullopt : next_view_,
                 .work = work_of(end),
                 .paused = status.paused,
                 .message = std::move(message),
                 .trouble = trouble_of(stats, end)});
}

MonitorState state_before_first(const LiveDisplay::Names& names, const std::vector<LinkState>& links,
                                const Capture* latest, std::string doing) {
  MonitorState state;
  state.version = SHEEN_VERSION;
  state.model = names.model;
  state.session_folder = names.session_folder;
  state.links = links_of(names, links);
  state.hint = commands_for_missing(names.trackers, links);
  state.doing = std::move(doing);
  if (latest) state.camera_jpeg = camera_preview(*latest, nullptr);
  return state;
}

MonitorState LiveDisplay::monitor_state(const LoopStatus& status, const EndProgress& end) {
  const Latest now = latest();
  update_previews(now);
  update_next_view(now);
  count_surface(now);
  MonitorState state;
  state.version = SHEEN_VERSION;
  state.model = names_.model;
  state.model_reason = names_.model_reason;
  state.session_folder = names_.session_folder;
  if (now.capture) {
    state.source_session = now.capture->source_session;
    state.photometric = photometric_knowledge(*now.capture);
  }
  const ReceiverStats stats = status.link();
  state.links = links_of(names_, status.links);
  state.hint = commands_for_missing(names_.trackers, status.links);
  state.ended = stats.ended;
  state.paused = status.paused;
  state.ending = ending_of(end);
  state.error = status.error;
  state.warnings = now.warnings;
  state.last_frame = now.capture_at;
  state.received = status.journaled;
  state.accepted = status.counts.accepted;
  state.held_out = status.counts.held_out;
  state.withdrawn = status.counts.withdrawn;
  state.waiting = status.waiting();
  state.journaled = status.journaled;
  state.sequence_gaps = stats.missing;
  state.refused = status.counts.refused;
  state.tracker = {stats.tracker.judged, stats.tracker.refused, trouble_of(stats, end)};
  state.images_per_s = status.images_per_s;
  state.queues["ingest"] = {status.waiting(), 0};
  state.stage_s = status.stage_s;
  state.update = summarize(status.update);
  state.latency = summarize(status.latency.to_disk);
  state.model_latency = summarize(status.latency.to_model);
  state.picture_latency = summarize(status.latency.to_picture);
  state.rank_histogram = status.rank_histogram;
  state.model_bytes = status.model_bytes;
  if (counted_ > 0) state.surface = surface_;
  state.trade = status.trade;
  state.held_out_curve = status.held_out_curve;
  if (!lags(status)) {
    state.next_view = guidance_in_words(now);
    state.well_known = next_view_ && next_view_->well_known;
  }
  state.preview_jpeg = preview_jpeg_;
  state.preview_note = preview_note_;
  if (now.snapshot) state.shape = shape_of(now.snapshot->mesh());
  state.shape_jpeg = shape_jpeg_;
  state.camera_jpeg = camera_jpeg_;
  return state;
}

void LiveDisplay::update_previews(const Latest& now) {
  if (now.capture && now.capture != drawn_capture_) {
    drawn_capture_ = now.capture;
    camera_jpeg_ = camera_preview(*now.capture, now.painter.get());
  }
  if (!now.snapshot || now.number == drawn_) return;
  const bool posed = now.capture && now.capture->pose.usable();
  if (!posed && !now.snapshot->empty()) return;
  drawn_ = now.number;
  const Viewpoint from = preview_viewpoint(posed ? now.capture.get() : nullptr, now.snapshot->shared_mesh());
  preview_note_ = no_photograph_note(*now.snapshot, from.eye());
  preview_jpeg_ = model_preview(*now.snapshot, *now.painter, from);
  shape_jpeg_ = shape_preview(now.snapshot->mesh(), *now.painter, from);
}

void LiveDisplay::count_surface(const Latest& now) {
  if (!now.snapshot || now.number == counted_) return;
  counted_ = now.number;
  const SnapshotFigures figures = now.snapshot->figures();
  surface_ = {.seen = figures.seen, .measured = figures.measured};
}

void LiveDisplay::update_next_view(const Latest& now) {
  if (!now.snapshot || !now.capture || !now.capture->pose.usable() || now.number == advised_) return;
  advised_ = now.number;
  const ViewAdvice advice = now.snapshot->advise_next_view(camera_centre(now.capture->pose.camera_from_object));
  if (next_view_ && !advice.well_known() && keeps_asking_for(*next_view_, now, advice.eye)) return;
  otherwise_ = 0;
  next_view_ = NextView{advice.eye, advice.reason, advice.well_known()};
  if (!next_view_->well_known) return;
  next_view_->reason = format("%.0f dB are expected even from the least known place", advice.worst_psnr_db);
}

/// Whoever is on the way somewhere is not sent elsewhere by every image: only once they are there, or when several
/// snapshots in a row want another view.
bool LiveDisplay::keeps_asking_for(const NextView& asked, const Latest& now, const Eigen::Vector3d& wanted) {
  if (asked.well_known) return false;
  const Eigen::Vector3d centre = bounding_sphere(now.snapshot->mesh()).centre;
  if (guide(now.capture->pose.camera_from_object, centre, asked.eye).there()) return false;
  const double cosine = (wanted - centre).normalized().dot((asked.eye - centre).normalized());
  otherwise_ = cosine > kSameView ? 0 : otherwise_ + 1;
  return otherwise_ < kInsists;
}

std::string LiveDisplay::guidance_in_words(const Latest& now) const {
  if (!next_view_ || !now.snapshot || !now.capture || !now.capture->pose.usable()) return {};
  if (next_view_->well_known) return next_view_->reason;
  const Guidance way =
      guide(now.capture->pose.camera_from_object, bounding_sphere(now.snapshot->mesh()).centre, next_view_->eye);
  return advice_in_words(way, next_view_->reason);
}

}  // namespace sheen
