// SPDX-License-Identifier: Apache-2.0
#include "tracker/tracking_loop.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <exception>
#include <thread>

#include "common/base/bounded_queue.h"
#include "common/base/clock.h"
#include "common/base/content_hash.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/base/guarded_thread.h"
#include "common/base/log.h"
#include "common/base/sparing_log.h"
#include "common/capture/frame_advice.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPoll{50};
constexpr milliseconds kKeepWait{100};
constexpr int kLiveKeepWaits = 10;  ///< a camera's keyframe waits a second for room, a file's for ever
constexpr std::int64_t kPublishEvery_ns = 200'000'000;
constexpr std::int64_t kSilent_ns = 1'000'000'000;  ///< a person is told that a camera delivers nothing
constexpr double kMoved_px = 1;                     ///< by which a still camera's tags are elsewhere
constexpr std::size_t kTimesKept = 4096;
/// Frames that say whether something is wrong now (one that is kept, and nothing is): so many, or those of a second.
constexpr std::size_t kLatest = 12;
constexpr std::int64_t kLatest_ns = 1'000'000'000;

void note_time(TrackingReport& report, const std::string& stage, double ms) {
  std::vector<float>& times = report.stage_ms[stage];
  if (times.size() == kTimesKept) times.erase(times.begin(), times.begin() + kTimesKept / 2);
  times.push_back(static_cast<float>(ms));
}

/// Adds the time until its destruction to a stage of the report.
class StageTimer {
 public:
  StageTimer(TrackingReport& report, const char* stage) : report_(report), stage_(stage) {}
  ~StageTimer() { note_time(report_, stage_, static_cast<double>(steady_now_ns() - start_) * 1e-6); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  TrackingReport& report_;
  const char* stage_;
  const std::int64_t start_ = steady_now_ns();
};

/// Identifies the camera's calibration; not a secret, only has to change with them.
std::string calibration_hash(const Rig& rig) {
  const Camera& c = rig.camera;
  std::string calibration;
  const auto add = [&calibration](double value) { calibration += format(" %.17g", value); };
  for (const double value : {double(c.width), double(c.height), c.fx, c.fy, c.cx, c.cy, double(c.lens)}) add(value);
  for (const double value : c.distortion) add(value);
  if (const std::optional<Photometry>& p = rig.photometry) {
    for (const float value : p->response) add(value);
    for (const double value : {p->vignette.cx, p->vignette.cy, double(p->saturation)}) add(value);
    for (const double value : p->vignette.k) add(value);
    for (const float value : p->white_balance) add(value);
  }
  return content_hash(calibration);
}

GateOptions gate_of(GateOptions gate, const FrameSource& source) {
  if (gate.max_uncertainty_px == 0)
    gate.max_uncertainty_px = source.compressed() ? kCompressedUncertainty_px : kCameraUncertainty_px;
  return gate;
}

/// What became of a frame, for a person.
struct Fate {
  std::int64_t taken_ns = 0;
  bool kept = false;
  std::string trouble;  ///< empty: nothing that a person should know
};

/// What the latest frames were refused for most often, where none of them was kept and half have such a reason.
std::string trouble_of(const std::deque<Fate>& latest) {
  if (latest.size() < kLatest) return {};
  std::map<std::string, std::size_t> counts;
  for (const Fate& fate : latest) {
    if (fate.kept) return {};
    ++counts[fate.trouble];
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return 2 * most->second >= latest.size() ? most->first : "";
}

/// RMS, pixels, of the tags that a frame's pose rests on, under another pose.
double rms_under(const Rigid3& pose, const Capture& capture, const StageLayout& stage) {
  double sum = 0;
  int corners = 0;
  for (const TagObservation& tag : capture.tags) {
    const StageTag* known = tag.used ? stage.find(tag.id) : nullptr;
    for (std::size_t k = 0; known && k < tag.corners.size(); ++k, ++corners) {
      const auto pixel = capture.camera.project(pose * known->corners_object[k]);
      sum += pixel ? (*pixel - tag.corners[k]).squaredNorm() : INFINITY;
    }
  }
  return corners > 0 ? std::sqrt(sum / corners) : INFINITY;
}

}  // namespace

struct TrackingLoop::Impl {
  FrameSource& source;
  CaptureSink& sink;
  const std::optional<Rig> rig;
  const TrackingOptions options;
  const ObjectRegion region;
  const std::string calibration, stage_hash;
  std::optional<StageFinder> finder;  ///< with the rig
  BlurPredictor blur;
  KeyframeGate gate;
  BoundedQueue<Frame> grabbed;
  std::atomic<std::uint64_t> grabbed_count = 0, overrun_count = 0;
  std::exception_ptr grab_error;  ///< read once the queue is closed
  TrackingReport report;
  std::int64_t published_ns = 0;
  std::optional<std::int64_t> stale_since_ns;
  SourceState published_state = SourceState::kStarting;
  std::string last_verdict;
  bool lens_told = false;     ///< that the lens is not as it was calibrated
  std::deque<Fate> latest;    ///< the newest last
  double uncertainty_px = 0;  ///< of the last pose that was too uncertain
  std::optional<PoseEstimate> still_pose;

  Impl(FrameSource& s, CaptureSink& k, std::optional<Rig> r, const TrackingOptions& o)
      : source(s),
        sink(k),
        rig(std::move(r)),
        options(o),
        region(rig ? object_region(rig->stage) : ObjectRegion{}),
        calibration(rig ? calibration_hash(*rig) : ""),
        stage_hash(rig ? rig->stage.hash() : ""),
        gate(gate_of(o.gate, s), region),
        grabbed(o.queue) {
    if (!rig) return;
    StageFinderOptions find = o.finder;
    find.other_tags = rig->lights && rig->lights->reads_tags();
    finder.emplace(rig->camera, rig->stage, find);
  }

  void grab(const std::stop_token& stop);
  void track(const Hooks& hooks);
  struct Measured {
    Capture capture;
    std::string refusal;  ///< by the rig, of what else would be a keyframe; else empty
  };
  Measured measure(Frame frame);
  std::string hold_still(Capture& capture);
  std::string find_light(Capture& capture);
  void check_size(const Frame& frame) const;
  void find_pose(const Frame& frame, Capture& capture);
  void judge(Frame& frame, Capture& capture);
  void send(Measured measured, const Hooks& hooks);
  void note(const std::string& verdict, Fate fate);
  void watch_lens(const Capture& capture);
  std::string trouble() const;
  bool keep(const Capture& capture, const Hooks& hooks);
  void publish(const Hooks& hooks);
  /// What only shows the capture cannot end it.
  template <typename Showing>
  void unharmed(const Showing& showing) {
    guarded(showing, [this](const std::exception_ptr& error) {
      const std::string what = words_of(error);
      shows_log.tell(what, "the capture goes on, though it could not be shown: " + what);
    });
  }
  SparingLog shows_log{"tracker"};
};

void TrackingLoop::Impl::grab(const std::stop_token& stop) {
  while (!stop.stop_requested() && !source.ended() && (options.max_frames == 0 || grabbed_count < options.max_frames)) {
    auto frame = source.next(kPoll);
    if (!frame) continue;
    ++grabbed_count;
    if (source.live() ? !grabbed.try_push(std::move(*frame)) : !grabbed.push(std::move(*frame))) ++overrun_count;
  }
  grabbed.close();
}

void TrackingLoop::Impl::track(const Hooks& hooks) {
  while (!hooks.stop()) {
    auto frame = grabbed.pop_for(kPoll);
    if (!frame && grabbed.closed() && grabbed.size() == 0) return;
    if (frame) send(measure(std::move(*frame)), hooks);
    unharmed([&] { publish(hooks); });
  }
}

TrackingLoop::Impl::Measured TrackingLoop::Impl::measure(Frame frame) {
  if (frame.given) {
    Capture capture = std::move(*frame.given);
    capture.times = frame.times;
    return {std::move(capture), {}};
  }
  check_size(frame);
  Capture capture;
  capture.source_session = options.source_session;
  capture.camera_frame_id = frame.camera_frame_id;
  capture.name =
      (options.camera_name.empty() ? "" : options.camera_name + " ") + "frame " + std::to_string(frame.camera_frame_id);
  capture.times = frame.times;
  capture.camera = rig->camera;
  capture.exposure = frame.exposure;
  capture.photometry = rig->photometry;
  capture.calibration_hash = calibration;
  capture.stage_hash = stage_hash;
  if (frame.complete) find_pose(frame, capture);
  std::string refusal;
  if (capture.pose.usable() && rig->still) refusal = hold_still(capture);
  if (capture.pose.usable() && rig->lights && refusal.empty()) refusal = find_light(capture);
  judge(frame, capture);
  capture.image = std::move(frame.image);
  if (capture.verdict != FrameVerdict::kKeyframe) refusal.clear();  // it is refused for what it shows
  if (capture.verdict == FrameVerdict::kKeyframe && refusal.empty() && rig->still && !still_pose)
    still_pose = capture.pose;
  return {std::move(capture), std::move(refusal)};
}

/// Gives a frame the pose that a still camera has; says so where its tags are elsewhere.
std::string TrackingLoop::Impl::hold_still(Capture& capture) {
  if (!still_pose) return {};
  if (rms_under(still_pose->camera_from_object, capture, rig->stage) >
      std::max(kMoved_px, 2 * capture.pose.reprojection_rms_px))
    return "camera_moved";
  capture.pose.camera_from_object = still_pose->camera_from_object;
  capture.pose.covariance = still_pose->covariance;
  return {};
}

std::string TrackingLoop::Impl::find_light(Capture& capture) {
  const StageTimer timer(report, "light");
  FrameLights::Answer answer = rig->lights->of(capture);
  if (answer.light) capture.light = *answer.light;
  return std::move(answer.refusal);
}

void TrackingLoop::Impl::check_size(const Frame& frame) const {
  const RawImage& image = frame.image;
  if (!frame.complete || (image.width == rig->camera.width && image.height == rig->camera.height)) return;
  throw ConfigError("the source delivers " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                    " pixels, but the configuration's [camera] is " + std::to_string(rig->camera.width) + " x " +
                    std::to_string(rig->camera.height));
}

void TrackingLoop::Impl::find_pose(const Frame& frame, Capture& capture) {
  ImageU8 grey;
  {
    const StageTimer timer(report, "balance");
    grey = detection_image(frame.image);
  }
  StageSighting sighting = finder->find(grey);
  for (const auto& [stage, ms] : sighting.stage_ms) note_time(report, stage, ms);
  capture.tags = std::move(sighting.tags);
  capture.pose = sighting.pose;
  if (!capture.pose.usable()) return;
  const StageTimer timer(report, "blur");
  const double predicted = blur.predict(rig->camera, region, capture.pose.camera_from_object, frame.times.device_ns,
                                        frame.exposure.exposure_s);
  capture.pose.blur_px =
      std::max(predicted, measured_streak_px(grey, rig->camera, capture.tags, options.finder.refiner));
}

void TrackingLoop::Impl::judge(Frame& frame, Capture& capture) {
  const StageTimer timer(report, "gate");
  capture.verdict = gate.judge(rig->camera, frame.image, frame.complete, capture.pose, capture.light);
  if (capture.verdict == FrameVerdict::kUncertainPose) uncertainty_px = gate.uncertainty_px(rig->camera, capture.pose);
}

void TrackingLoop::Impl::note(const std::string& verdict, Fate fate) {
  last_verdict = verdict;
  latest.push_back(std::move(fate));
  while (latest.size() > kLatest && latest.back().taken_ns - latest.front().taken_ns > kLatest_ns) latest.pop_front();
}

/// With the figures that decide, where a key of the configuration does.
std::string TrackingLoop::Impl::trouble() const {
  const std::string trouble = trouble_of(latest);
  if (trouble != advice(FrameVerdict::kUncertainPose)) return trouble;
  return trouble +
         format(" (it is %.2f px, [gate] max_uncertainty_px is %g)", uncertainty_px, gate.max_uncertainty_px());
}

void TrackingLoop::Impl::send(Measured measured, const Hooks& hooks) {
  const StageTimer timer(report, "send");
  Capture& capture = measured.capture;
  ++report.judged;
  ++report.poses[capture.pose.status];
  if (!measured.refusal.empty()) {
    ++report.rig_refusals[measured.refusal];
    return note(measured.refusal,
                {capture.times.device_ns, false, "the rig does not bear it out: " + measured.refusal});
  }
  ++report.verdicts[capture.verdict];
  note(to_string(capture.verdict),
       {capture.times.device_ns, capture.verdict == FrameVerdict::kKeyframe, advice(capture.verdict)});
  if (capture.verdict == FrameVerdict::kIncomplete) return;  // part of the picture is missing: nothing to look at
  if (capture.verdict != FrameVerdict::kKeyframe) {
    ++report.live;
    unharmed([&] { sink.live(std::move(capture)); });
    return;
  }
  watch_lens(capture);
  ++report.unsent;  // until the link has it
  if (!keep(capture, hooks)) return;
  --report.unsent;
  ++report.kept;
  if (rig) gate.remember(capture.pose, capture.light);
}

void TrackingLoop::Impl::watch_lens(const Capture& capture) {
  if (capture.pose.status != PoseStatus::kTracked || rig->still) return;
  if (const auto deviation = focal_deviation(rig->camera, rig->stage, capture.tags, capture.pose.camera_from_object))
    report.focal.add(*deviation);
  const std::string finding = lens_told ? "" : report.focal.finding();
  if (finding.empty()) return;
  lens_told = true;
  log_warning("tracker", (options.camera_name.empty() ? "" : options.camera_name + ": ") + finding);
}

bool TrackingLoop::Impl::keep(const Capture& capture, const Hooks& hooks) {
  for (int waits = 0; !source.live() || waits < kLiveKeepWaits; ++waits) {
    if (sink.keep(capture, kKeepWait)) return true;
    if (hooks.stop()) return false;
    unharmed([&] { publish(hooks); });
  }
  return false;
}

void TrackingLoop::Impl::publish(const Hooks& hooks) {
  const std::int64_t now = steady_now_ns();
  const SourceState state = source.state();
  if (state == published_state && now - published_ns < kPublishEvery_ns) return;  // an unplugged camera is news
  published_state = state;
  published_ns = now;
  report.grabbed = grabbed_count;
  report.overrun = overrun_count;
  if (state != SourceState::kStale) stale_since_ns.reset();
  if (state == SourceState::kStale && !stale_since_ns) stale_since_ns = now;
  report.trouble = stale_since_ns && now - *stale_since_ns >= kSilent_ns ? source.message() : trouble();
  if (hooks.progress) hooks.progress(report);
  if (!hooks.publish) return;
  Status status{.role = "tracker",
                .source_session = options.source_session,
                .clock_ns = now,
                .state = state,
                .message = source.message()};
  if (!report.trouble.empty() && report.trouble != status.message) status.message += "; " + report.trouble;
  if (!last_verdict.empty()) status.message += "; last frame: " + last_verdict;
  status.gauges = {{"frames_grabbed", double(grabbed_count)}, {"frames_overrun", double(overrun_count)},
                   {"frames_kept", double(report.kept)},      {"frames_live", double(report.live)},
                   {"frames_unsent", double(report.unsent)},  {"queue_depth", double(grabbed.size())}};
  for (const auto& [verdict, count] : report.verdicts)
    status.gauges[std::string("verdict_") + to_string(verdict)] = double(count);
  for (const auto& [reason, count] : report.rig_refusals) status.gauges["verdict_" + reason] = double(count);
  for (const auto& [stage, times] : report.stage_ms) status.gauges[stage + "_s"] = report.median_ms(stage) * 1e-3;
  hooks.publish(status);
}

TrackingLoop::TrackingLoop(FrameSource& source, CaptureSink& sink, std::optional<Rig> rig,
                           const TrackingOptions& options)
    : impl_(std::make_unique<Impl>(source, sink, std::move(rig), options)) {
  if (!impl_->rig && source.session().empty())
    throw ConfigError("this source's images have no poses: --config must name [camera] and [stage]");
}

TrackingLoop::~TrackingLoop() = default;

TrackingReport TrackingLoop::run(const Hooks& hooks) {
  Impl& loop = *impl_;
  std::jthread grabber = guarded_thread([&loop](const std::stop_token& stop) { loop.grab(stop); },
                                        [&loop](const std::exception_ptr& error) {
                                          loop.grab_error = error;
                                          loop.grabbed.close();
                                        });
  guarded([&] { loop.track(hooks); }, [&](const std::exception_ptr& error) { loop.report.failure = error; });
  grabber.request_stop();
  loop.grabbed.close();
  grabber.join();
  if (!loop.report.failure) loop.report.failure = loop.grab_error;
  loop.report.grabbed = loop.grabbed_count;
  loop.overrun_count = loop.grabbed_count - loop.report.judged;  // with those that waited when the run ended
  loop.report.overrun = loop.overrun_count;
  loop.report.source = loop.source.stats();
  loop.published_ns = 0;
  loop.unharmed([&] { loop.publish(hooks); });
  return loop.report;
}

}  // namespace sheen
