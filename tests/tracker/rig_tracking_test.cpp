// SPDX-License-Identifier: Apache-2.0
#include "tracker/rig_tracking.h"

#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>
#include <tuple>

#include "common/base/errors.h"
#include "tests/support/link.h"
#include "tests/tracker/synthetic_stage.h"
#include "tracker/commands/live_line.h"
#include "tracker/link_sink.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;

/// So many pictures of a stage, then its end; or a failure in its place, or silence.
class StageSource : public FrameSource {
 public:
  enum class Then { kEnds, kFails, kFallsSilent };
  StageSource(ImageU8 picture, std::uint64_t frames, Then then)
      : picture_(std::move(picture)), frames_(frames), then_(then) {}

  std::optional<Frame> next(milliseconds timeout) override {
    if (next_ == frames_ && then_ == Then::kFails) throw DeviceError("the cable broke");
    if (next_ >= frames_) {
      std::this_thread::sleep_for(timeout);
      return std::nullopt;
    }
    Frame f;
    f.camera_frame_id = next_++;
    f.times.device_ns = std::int64_t(f.camera_frame_id) * 1'000'000'000;
    f.exposure.exposure_s = 0.001;
    f.image = {.format = PixelFormat::kMono8,
               .width = picture_.width(),
               .height = picture_.height(),
               .stride = std::size_t(picture_.width()),
               .bytes = {picture_.data(), picture_.data() + picture_.size()}};
    return f;
  }
  SourceState state() const override {
    if (next_ < frames_ || then_ == Then::kFails) return SourceState::kLive;
    return then_ == Then::kFallsSilent ? SourceState::kStale : SourceState::kEnded;
  }
  std::string message() const override { return state() == SourceState::kStale ? "no frame comes" : "delivers"; }
  SourceStats stats() const override { return {.frames = next_, .missed = 2}; }
  bool live() const override { return false; }

 private:
  const ImageU8 picture_;
  const std::uint64_t frames_;
  const Then then_;
  std::atomic<std::uint64_t> next_ = 0;
};

class RigOfTwo : public ::testing::Test {
 protected:
  using Then = StageSource::Then;

  /// Two cameras whose frames all show one view each: the first is a keyframe, the others are too near.
  std::vector<TrackedCamera> cameras(Then left, Then right) {
    std::mt19937 rng(3);
    std::vector<TrackedCamera> both;
    for (const auto& [name, frames, then] : {std::tuple{"left", 5, left}, std::tuple{"right", 9, right}}) {
      TrackedCamera camera{
          .name = name, .source = {}, .rig = Rig{testing::stage_camera(), make_stage({})}, .options = {}};
      const Rigid3 pose = testing::random_stage_pose(rng, 40);
      camera.source = std::make_unique<StageSource>(
          testing::render_stage(camera.rig->camera, camera.rig->stage, pose, 4), frames, then);
      camera.options.camera_name = name;
      camera.sink = &sink_.of(both.size());
      both.push_back(std::move(camera));
    }
    return both;
  }
  std::string json_of(const RigReport& report) { return to_json(report, {{"unacknowledged", 2}}); }

  CaptureSender sender_{testing::sender_options()};
  LinkSink sink_{sender_, 2};
};

TEST_F(RigOfTwo, EachHasItsOwnGateAndItsOwnAccount) {
  RigReport report = RigTracking(cameras(Then::kEnds, Then::kEnds)).run({.stop = [] { return false; }});
  ASSERT_EQ(report.size(), 2u);
  EXPECT_EQ(report[0].name, "left");
  EXPECT_EQ(report[0].report.judged, 5u);
  EXPECT_EQ(report[1].report.judged, 9u);
  for (const CameraReport& camera : report) {
    EXPECT_EQ(camera.report.kept, 1u) << "the other camera's view is no reason to refuse this one's";
    EXPECT_EQ(camera.report.verdicts.at(FrameVerdict::kTooNear), camera.report.judged - 1);
  }
  EXPECT_EQ(sink_.unacknowledged(), (std::vector<std::uint64_t>{1, 1}));
  for (CameraReport& camera : report) camera.unacknowledged = 1;

  CaptureReceiver receiver(testing::receiver_options(sender_.endpoint()));
  std::set<std::string> names;
  for (std::uint64_t sequence = 1; sequence <= 2; ++sequence) {
    const auto got = receiver.next(testing::kLong);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->capture.sequence, sequence) << "one session for both";
    names.insert(got->capture.name);
    receiver.acknowledge("s", sequence);
  }
  EXPECT_EQ(names, (std::set<std::string>{"left frame 0", "right frame 0"}));
  EXPECT_TRUE(testing::eventually([&] { return sink_.unacknowledged() == std::vector<std::uint64_t>{0, 0}; }));

  EXPECT_EQ(live_line(report), "14 frames, 2 kept (left 1 of 5, right 1 of 9), 12 refused (12 too_near)");
  EXPECT_EQ(summary(report),
            "14 frames, 2 keyframes sent, 12 too_near, 4 never seen\n  left: 5 frames, 1 keyframes sent, 4 too_near, 2 "
            "never seen\n  right: 9 frames, 1 keyframes sent, 8 too_near, 2 never seen");
  const auto json = nlohmann::json::parse(json_of(report));
  EXPECT_EQ(json["frames"]["camera"], 18);
  EXPECT_EQ(json["frames"]["lost"], 6);
  EXPECT_EQ(json["cameras"]["left"]["frames"]["camera"], 7);
  EXPECT_EQ(json["cameras"]["left"]["frames"]["lost"], 3);
  EXPECT_EQ(json["cameras"]["right"]["frames"]["refused"]["too_near"], 8);
  EXPECT_TRUE(json["failure"].is_null());
}

TEST_F(RigOfTwo, OneThatFailsIsNamedAndTheOtherGoesOn) {
  std::vector<std::string> told;
  const RigReport report = RigTracking(cameras(Then::kFails, Then::kEnds))
                               .run({.stop = [] { return false; },
                                     .publish = {},
                                     .progress = {},
                                     .failed = [&](const std::string& failure) { told.push_back(failure); }});
  EXPECT_EQ(told, std::vector<std::string>{"left: the cable broke"});
  EXPECT_EQ(report[0].report.judged, 5u);
  EXPECT_EQ(report[1].report.judged, 9u);
  EXPECT_EQ(total(report).failure_text(), "left: the cable broke");
  EXPECT_EQ(total(report).trouble, "left: the cable broke");
  const auto json = nlohmann::json::parse(json_of(report));
  EXPECT_EQ(json["failure"], "left: the cable broke");
  EXPECT_EQ(json["cameras"]["left"]["failure"], "the cable broke");
  EXPECT_TRUE(json["cameras"]["right"]["failure"].is_null());
}

TEST_F(RigOfTwo, OneThatFallsSilentIsToldToThePerson) {
  std::atomic<bool> stop = false;
  std::string line;
  Status last;
  RigTracking(cameras(Then::kEnds, Then::kFallsSilent))
      .run({.stop = [&] { return stop.load(); },
            .publish = [&](const Status& status) { last = status; },
            .progress =
                [&](const RigReport& so_far) {
                  if (total(so_far).trouble.empty() || total(so_far).judged < 14) return;
                  line = live_line(so_far);
                  stop = true;
                },
            .failed = {}});
  EXPECT_TRUE(line.starts_with("RIGHT: NO FRAME COMES  14 frames")) << line;
  EXPECT_EQ(last.state, SourceState::kStale);
  EXPECT_EQ(last.gauges.at("frames_grabbed"), 14);
  EXPECT_EQ(last.gauges.at("left/frames_grabbed"), 5);
  EXPECT_EQ(last.gauges.at("right/frames_kept"), 1);
}

}  // namespace
}  // namespace sheen
