// SPDX-License-Identifier: Apache-2.0
#include "tracker/tracking_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <new>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/errors.h"
#include "tests/tracker/synthetic_stage.h"
#include "tracker/commands/live_line.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;

/// Hands out what it was given; a live one does not wait for anybody.
class ScriptedSource : public FrameSource {
 public:
  explicit ScriptedSource(bool live) : live_(live) {}
  std::optional<Frame> next(milliseconds) override {
    if (next_ == frames.size()) return std::nullopt;
    if (throw_at == static_cast<int>(next_)) throw FileError("image 3", "is broken");
    ++next_;
    return frames[next_ - 1];
  }
  SourceState state() const override { return next_ < frames.size() ? SourceState::kLive : SourceState::kEnded; }
  std::string message() const override { return "scripted"; }
  SourceStats stats() const override { return {.frames = next_, .missed = missed}; }
  bool live() const override { return live_; }
  bool compressed() const override { return lossy; }
  std::string session() const override { return session_name; }

  std::vector<Frame> frames;
  std::string session_name;
  bool lossy = false;
  int throw_at = -1;
  std::uint64_t missed = 0;

 private:
  const bool live_;
  std::atomic<std::size_t> next_ = 0;
};

class RecordingSink : public CaptureSink {
 public:
  bool keep(Capture capture, milliseconds timeout) override {
    if (full) {
      std::this_thread::sleep_for(timeout / 10);
      return false;
    }
    if (slow) std::this_thread::sleep_for(milliseconds(20));
    kept.push_back(std::move(capture));
    return true;
  }
  void live(Capture capture) override {
    if (fails_to_show) throw std::bad_alloc();
    shown.push_back(std::move(capture));
  }

  bool full = false, slow = false, fails_to_show = false;
  std::vector<Capture> kept, shown;
};

RigReport alone(const TrackingReport& report) {
  return {{.name = "", .report = report}};
}

const TrackingLoop::Hooks kNoHooks{.stop = [] { return false; }};

/// Frames of a stage from a few places, rendered once.
class TrackedStage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    std::mt19937 rng(11);
    for (int i = 0; i < 3; ++i) {
      poses.push_back(testing::random_stage_pose(rng, 40));
      pictures.push_back(testing::render_stage(rig().camera, rig().stage, poses.back(), 4));
    }
  }
  static Rig rig() { return {testing::stage_camera(), make_stage({})}; }

  static Frame frame(const ImageU8& picture, std::uint64_t id) {
    Frame f;
    f.camera_frame_id = id;
    f.times.device_ns = std::int64_t(id) * 1'000'000'000;  // a second apart: no motion is known
    f.exposure.exposure_s = 0.001;
    f.image = {.format = PixelFormat::kMono8,
               .width = picture.width(),
               .height = picture.height(),
               .stride = std::size_t(picture.width()),
               .bytes = {picture.data(), picture.data() + picture.size()}};
    return f;
  }

  static void expect_accounted(const TrackingReport& r) {
    EXPECT_EQ(r.grabbed, r.overrun + r.judged);
    std::uint64_t judged = 0;
    for (const auto& [verdict, count] : r.verdicts) judged += count;
    for (const auto& [reason, count] : r.rig_refusals) judged += count;
    EXPECT_EQ(r.judged, judged);
    const auto keyframes = r.verdicts.find(FrameVerdict::kKeyframe);
    EXPECT_EQ(r.kept + r.unsent, keyframes == r.verdicts.end() ? 0 : keyframes->second);
  }

  static inline std::vector<Rigid3> poses;
  static inline std::vector<ImageU8> pictures;
};

TEST_F(TrackedStage, EveryFrameIsAccountedForByReason) {
  ScriptedSource source(false);
  source.frames = {frame(pictures[0], 1), frame(pictures[0], 2), frame(pictures[1], 3),
                   frame(ImageU8(1024, 768, 1, 128), 4), frame(pictures[2], 5)};
  source.frames.push_back(frame(pictures[2], 6));
  source.frames.back().complete = false;
  source.frames.push_back(frame(ImageU8(1024, 768, 1, 0), 7));
  RecordingSink sink;
  const TrackingReport report = TrackingLoop(source, sink, rig(), {.source_session = "test"}).run(kNoHooks);
  expect_accounted(report);
  EXPECT_EQ(report.grabbed, 7u);
  EXPECT_EQ(report.overrun, 0u);
  EXPECT_EQ(report.kept, 3u);
  EXPECT_EQ(report.verdicts.at(FrameVerdict::kTooNear), 1u);
  EXPECT_EQ(report.verdicts.at(FrameVerdict::kNoPose), 2u);
  EXPECT_EQ(report.verdicts.at(FrameVerdict::kIncomplete), 1u);
  EXPECT_EQ(sink.shown.size(), 3u);
  ASSERT_EQ(sink.kept.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    const Capture& capture = sink.kept[i];
    EXPECT_EQ(capture.source_session, "test");
    EXPECT_EQ(capture.stage_hash, rig().stage.hash());
    EXPECT_FALSE(capture.calibration_hash.empty());
    EXPECT_EQ(capture.camera, rig().camera);
    EXPECT_LT((camera_centre(capture.pose.camera_from_object) - camera_centre(poses[i])).norm(), 1e-4);
  }
  const auto json = nlohmann::json::parse(to_json(alone(report), {{"acknowledged", 3}}));
  EXPECT_EQ(json["frames"]["grabbed"], 7);
  EXPECT_EQ(json["frames"]["sent"], 3);
  EXPECT_EQ(json["frames"]["refused"].size(), 3u);
}

/// Lights by frame; none beyond them.
class ListedLights : public FrameLights {
 public:
  explicit ListedLights(std::vector<Eigen::Vector3d> places) : places_(std::move(places)) {}
  Answer of(const Capture& frame) override {
    if (frame.camera_frame_id >= places_.size()) return {std::nullopt, "beyond_light_table"};
    return {LightState{.kind = LightKind::kPoint, .position = places_[frame.camera_frame_id]}, {}};
  }

 private:
  std::vector<Eigen::Vector3d> places_;
};

TEST_F(TrackedStage, ALampThatMovesMakesAViewNew) {
  ScriptedSource source(false);
  for (std::uint64_t i = 0; i < 5; ++i) source.frames.push_back(frame(pictures[0], i));
  RecordingSink sink;
  Rig lit = rig();
  lit.lights = std::make_shared<ListedLights>(
      std::vector<Eigen::Vector3d>{{0, 0, 1}, {0.3, 0, 1}, {0.301, 0, 1}, {0, 0.3, 1}});  // the third moves by 1 mm
  const TrackingReport report = TrackingLoop(source, sink, lit, {}).run(kNoHooks);
  expect_accounted(report);
  ASSERT_EQ(sink.kept.size(), 3u);
  EXPECT_EQ(sink.kept[1].light.position, Eigen::Vector3d(0.3, 0, 1));
  EXPECT_EQ(sink.kept[2].light.kind, LightKind::kPoint);
  EXPECT_EQ(report.verdicts.at(FrameVerdict::kTooNear), 1u);
  EXPECT_EQ(report.rig_refusals.at("beyond_light_table"), 1u);
  EXPECT_EQ(frames_for_link(report).refused.at("beyond_light_table"), 1u);
  const auto json = nlohmann::json::parse(to_json(alone(report), {}));
  EXPECT_EQ(json["frames"]["refused"]["beyond_light_table"], 1);
}

TEST_F(TrackedStage, AStillCameraHasOnePoseUntilItIsMoved) {
  ScriptedSource source(false);
  for (std::uint64_t i = 0; i < 4; ++i) {
    ImageU8 picture = pictures[i == 3 ? 1 : 0];
    std::mt19937 rng(static_cast<unsigned>(i));
    testing::add_pixel_noise(picture, 2, rng);
    source.frames.push_back(frame(picture, i));
  }
  RecordingSink sink;
  Rig lit = rig();
  lit.still = true;
  lit.lights =
      std::make_shared<ListedLights>(std::vector<Eigen::Vector3d>{{0, 0, 1}, {0.3, 0, 1}, {0.6, 0, 1}, {0, 0.3, 1}});
  const TrackingReport report = TrackingLoop(source, sink, lit, {}).run(kNoHooks);
  expect_accounted(report);
  ASSERT_EQ(sink.kept.size(), 3u);
  for (const Capture& capture : sink.kept) {
    EXPECT_EQ(capture.pose.camera_from_object.matrix(), sink.kept[0].pose.camera_from_object.matrix());
    EXPECT_EQ(capture.pose.status, PoseStatus::kTracked);
  }
  EXPECT_EQ(report.rig_refusals.at("camera_moved"), 1u);
}

TEST_F(TrackedStage, WhatTheCameraSentIsReceivedOrLost) {
  ScriptedSource source(true);
  source.missed = 5;
  for (int i = 0; i < 12; ++i) source.frames.push_back(frame(pictures[i % 3], i));
  RecordingSink sink;
  sink.slow = true;
  const TrackingReport report = TrackingLoop(source, sink, rig(), {}).run(kNoHooks);
  const auto frames = nlohmann::json::parse(
      to_json(alone(report), {{"acknowledged", report.kept - 1}, {"unacknowledged", 1}}))["frames"];
  std::uint64_t refused = 0;
  for (const auto& count : frames["refused"]) refused += count.get<std::uint64_t>();
  EXPECT_EQ(frames["camera"], 17);
  EXPECT_EQ(frames["received"], report.kept - 1 + refused);
  EXPECT_EQ(frames["lost"], 5 + report.overrun + report.unsent + 1);
  EXPECT_EQ(frames["camera"], frames["received"].get<int>() + frames["lost"].get<int>());
}

TEST_F(TrackedStage, FastMotionIsRefusedAsBlur) {
  ScriptedSource source(false);
  source.frames = {frame(pictures[0], 1), frame(pictures[1], 2)};
  source.frames[1].times.device_ns = source.frames[0].times.device_ns + 100'000'000;
  source.frames[1].exposure.exposure_s = 0.01;
  RecordingSink sink;
  const TrackingReport report = TrackingLoop(source, sink, rig(), {}).run(kNoHooks);
  EXPECT_EQ(report.verdicts.at(FrameVerdict::kMotionBlur), 1u);
}

TEST_F(TrackedStage, SaysWhatIsWrongWhileItRefusesWhatComes) {
  ScriptedSource source(false);
  for (std::uint64_t i = 0; i < 16; ++i) {  // to and fro within a tenth of a second each
    source.frames.push_back(frame(pictures[i % 2], i + 1));
    source.frames.back().times.device_ns = std::int64_t(i) * 100'000'000;
    source.frames.back().exposure.exposure_s = i == 0 ? 0.001 : 0.01;
  }
  RecordingSink sink;
  TrackingLoop::Hooks hooks = kNoHooks;
  std::string told;
  hooks.progress = [&](const TrackingReport& so_far) { told = so_far.trouble; };
  const TrackingReport report = TrackingLoop(source, sink, rig(), {}).run(hooks);
  EXPECT_EQ(report.verdicts.at(FrameVerdict::kMotionBlur), 15u);
  EXPECT_EQ(report.trouble, "too fast: motion blur");
  EXPECT_EQ(told, report.trouble);
  const TrackerFrames sent = frames_for_link(report);
  EXPECT_EQ(sent.judged, 16u);
  EXPECT_EQ(sent.refused.at("motion_blur"), 15u);
  EXPECT_EQ(sent.refused.count("keyframe"), 0u);
  EXPECT_EQ(live_line(alone(report)), "TOO FAST: MOTION BLUR  16 frames, 1 kept, 15 refused (15 motion_blur)");
}

/// Noise as strong as what compression leaves of edges: 0.05 pixels are out of reach.
TEST_F(TrackedStage, WhatIsTooUncertainForACameraIsWhatCompressedVideoHas) {
  ScriptedSource camera(false), video(false);
  std::mt19937 rng(3);
  for (std::uint64_t i = 0; i < 15; ++i) {
    ImageU8 picture = pictures[i % 3];
    testing::add_pixel_noise(picture, 24, rng);
    camera.frames.push_back(frame(picture, i + 1));
  }
  video.frames = camera.frames;
  video.lossy = true;
  RecordingSink sink;
  EXPECT_GT(TrackingLoop(camera, sink, rig(), {}).run(kNoHooks).verdicts[FrameVerdict::kUncertainPose], 0u);
  EXPECT_EQ(TrackingLoop(video, sink, rig(), {}).run(kNoHooks).verdicts[FrameVerdict::kUncertainPose], 0u);

  TrackingOptions strict;
  strict.gate.max_uncertainty_px = 0.002;
  ScriptedSource again(false);
  again.frames = video.frames;
  again.lossy = true;
  const TrackingReport refused = TrackingLoop(again, sink, rig(), strict).run(kNoHooks);
  EXPECT_THAT(refused.trouble, ::testing::MatchesRegex("uncertain pose: .* \\(it is 0\\.[0-9]+ px, \\[gate\\] "
                                                       "max_uncertainty_px is 0\\.002\\)"));
  EXPECT_THAT(live_line(alone(refused)), ::testing::HasSubstr("OR ALLOW MORE (it is 0."));
}

TEST_F(TrackedStage, ACameraFasterThanTheTrackerLosesCountedFrames) {
  ScriptedSource source(true);
  for (int i = 0; i < 40; ++i) source.frames.push_back(frame(pictures[i % 3], i));
  RecordingSink sink;
  sink.slow = true;
  const TrackingReport report = TrackingLoop(source, sink, rig(), {}).run(kNoHooks);
  expect_accounted(report);
  EXPECT_EQ(report.grabbed, 40u);
  EXPECT_GT(report.overrun, 0u);
}

TEST_F(TrackedStage, AFullLinkIsCountedAndTheViewStaysWanted) {
  ScriptedSource source(true);
  source.frames = {frame(pictures[0], 1), frame(pictures[0], 2)};
  RecordingSink sink;
  sink.full = true;
  const TrackingReport report = TrackingLoop(source, sink, rig(), {}).run(kNoHooks);
  expect_accounted(report);
  EXPECT_EQ(report.unsent, 2u);  // the second is not too near: the first was never taken
}

TEST_F(TrackedStage, WhatCannotBeShownEndsNoCapture) {
  ScriptedSource source(false);
  RecordingSink sink;
  sink.fails_to_show = true;
  for (std::uint64_t i = 0; i < 6; ++i) source.frames.push_back(frame(pictures[i % 3], i));  // three are seen twice
  TrackingLoop loop(source, sink, rig(), {});
  int published = 0;
  const TrackingReport report = loop.run({.stop = [] { return false; },
                                          .publish =
                                              [&](const Status&) {
                                                ++published;
                                                throw std::bad_alloc();
                                              },
                                          .progress = {}});
  EXPECT_GT(published, 0);
  EXPECT_EQ(report.failure_text(), "");
  EXPECT_EQ(report.judged, 6u);
  EXPECT_EQ(sink.kept.size(), 3u);
  expect_accounted(report);
}

TEST_F(TrackedStage, StopsAfterTheAskedNumberOfFramesAndOnRequest) {
  ScriptedSource source(false);
  for (int i = 0; i < 10; ++i) source.frames.push_back(frame(pictures[0], i));
  RecordingSink sink;
  EXPECT_EQ(TrackingLoop(source, sink, rig(), {.max_frames = 3}).run(kNoHooks).grabbed, 3u);
  sink.full = true;
  const TrackingReport report = TrackingLoop(source, sink, rig(), {}).run({.stop = [] { return true; }});
  expect_accounted(report);
  EXPECT_LT(report.grabbed, 10u);
}

TEST_F(TrackedStage, GivenPosesPassUntouchedAndInOrder) {
  ScriptedSource source(false);
  source.session_name = "dataset:abc";
  for (int i = 0; i < 20; ++i) {
    Frame f;
    f.given = Capture{.source_session = "dataset:abc", .sequence = std::uint64_t(i + 1), .name = std::to_string(i)};
    f.given->image = frame(pictures[0], 0).image;
    f.given->pose = {.status = PoseStatus::kGiven, .camera_from_object = poses[i % 3]};
    f.given->verdict = FrameVerdict::kKeyframe;
    f.given->purpose = i % 5 == 0 ? Purpose::kHeldOut : Purpose::kTraining;
    source.frames.push_back(f);
  }
  RecordingSink sink;
  const TrackingReport report = TrackingLoop(source, sink, std::nullopt, {}).run(kNoHooks);
  expect_accounted(report);
  ASSERT_EQ(sink.kept.size(), 20u);
  for (int i = 0; i < 20; ++i) {
    const Capture &got = sink.kept[i], &sent = *source.frames[i].given;
    EXPECT_EQ(got.sequence, sent.sequence);
    EXPECT_EQ(got.name, sent.name);
    EXPECT_EQ(got.image, sent.image);
    EXPECT_EQ(got.purpose, sent.purpose);
    EXPECT_EQ(got.pose.camera_from_object.matrix(), sent.pose.camera_from_object.matrix());
  }
}

TEST_F(TrackedStage, ASourceThatFailsLosesNothingOfWhatItGave) {
  ScriptedSource broken(false);
  for (int i = 0; i < 10; ++i) broken.frames.push_back(frame(pictures[i % 3], i));
  broken.throw_at = 3;
  RecordingSink sink;
  const TrackingReport report = TrackingLoop(broken, sink, rig(), {}).run(kNoHooks);
  EXPECT_THROW(std::rethrow_exception(report.failure), FileError);
  EXPECT_EQ(report.failure_text(), "image 3: is broken");
  expect_accounted(report);
  EXPECT_EQ(report.grabbed, 3u);
  EXPECT_EQ(sink.kept.size(), 3u) << "what was grabbed before is kept";
  EXPECT_EQ(nlohmann::json::parse(to_json(alone(report), {}))["failure"], "image 3: is broken");

  ScriptedSource other_size(false);
  for (int i = 0; i < 10; ++i) other_size.frames.push_back(frame(ImageU8(640, 480, 1, 0), i));
  const TrackingReport refused = TrackingLoop(other_size, sink, rig(), {}).run(kNoHooks);
  EXPECT_THROW(std::rethrow_exception(refused.failure), ConfigError);
  expect_accounted(refused);

  EXPECT_THROW(TrackingLoop(other_size, sink, std::nullopt, {}), ConfigError);
}

}  // namespace
}  // namespace sheen
