// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/monitor/status_json.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "tests/reconstructor/monitor/sample_state.h"

namespace sheen {
namespace {

using namespace std::chrono_literals;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(StatusJson, SaysWhatTheStateSays) {
  const auto json =
      nlohmann::json::parse(status_json(sample_monitor_state(), CaptureState::kLive, 0.25, 0.5, {.preview = 3}));
  EXPECT_EQ(json["state"], "live");
  EXPECT_EQ(json["frames"]["accepted"], 121);
  EXPECT_EQ(json["frames"]["refused"]["object_not_in_view"], 17);
  EXPECT_EQ(json["frames"]["waiting"], 6);
  EXPECT_EQ(json["tracker"]["judged"], 731);
  EXPECT_EQ(json["tracker"]["refused"]["motion_blur"], 422);
  EXPECT_EQ(json["tracker"]["trouble"], "too fast: motion blur");
  EXPECT_TRUE(json["ending"].is_null());
  EXPECT_EQ(json["queues"]["send"]["capacity"], 64);
  EXPECT_EQ(json["links"][0]["endpoint"], "tcp://127.0.0.1:7410");
  EXPECT_EQ(json["held_out_curve"].back()["psnr_db"], 34.31);
  EXPECT_EQ(json["held_out_curve"].size(), sample_monitor_state().held_out_curve.size());
  EXPECT_EQ(json["published_age_s"], 0.25);
  EXPECT_EQ(json["frame_age_s"], 0.5);
  EXPECT_EQ(json["pictures"]["preview"], 3);
  EXPECT_EQ(json["pictures"]["camera"], 0);
  EXPECT_EQ(json["pictures"]["shape"], 0);
  EXPECT_EQ(json["shape"]["seen"], 0.81);
  EXPECT_EQ(json["shape"]["outlined"], 0.05);
  EXPECT_EQ(json["shape"]["guessed"], 0.14);
  EXPECT_EQ(json["pictures"]["preview_note"], "no photograph from here: the nearest is 34 degrees away");
}

TEST(StatusJson, SaysWhatIsTradedForWhat) {
  MonitorState state = sample_monitor_state();
  const auto trade_of = [&] {
    return nlohmann::json::parse(status_json(state, CaptureState::kLive, 0, 0, {}))["trade"];
  };
  const auto trade = trade_of();
  EXPECT_EQ(trade["favour"], "speed");
  EXPECT_EQ(trade["effort_level"], 2);
  EXPECT_EQ(trade["effort_levels"], 6);
  EXPECT_EQ(trade["update_fraction"], 0.5);
  EXPECT_NEAR(trade["image_s"].get<double>(), 0.121, 1e-12);
  EXPECT_NEAR(trade["budget_s"].get<double>(), 0.1, 1e-12);
  EXPECT_EQ(trade["budget_kept"], false);
  EXPECT_EQ(trade["resident_bytes"], 431e6);
  EXPECT_EQ(trade["grown_bytes"], 386e6);
  EXPECT_EQ(trade["memory_bytes"], 500e6);
  EXPECT_EQ(trade["memory_kept"], true);
  EXPECT_EQ(trade["target_db"], 35);
  EXPECT_EQ(trade["orthogonality_lost"], 3e-7);
  EXPECT_EQ(trade["energy_lost"], 2.5e-4);
  state.trade = {.budget_ms = 100};
  const auto unknown = trade_of();
  for (const char* key :
       {"favour", "image_s", "budget_kept", "memory_bytes", "memory_kept", "orthogonality_lost", "energy_lost"})
    EXPECT_TRUE(unknown[key].is_null()) << key << " is neither kept nor broken before an image";
}

TEST(StatusJson, UnknownIsNullAndBadTextIsRepaired) {
  MonitorState state = sample_monitor_state();
  state.held_out_curve.back().psnr_db = kNaN;
  state.session_folder = "caf\xe9";
  state.shape.reset();
  state.doing = "The shape is being found in 9 images.";
  const auto json = nlohmann::json::parse(status_json(state, CaptureState::kWaiting, 0, kNaN, {}));
  EXPECT_TRUE(json["shape"].is_null()) << "of a mesh that was given";
  EXPECT_EQ(json["doing"], "The shape is being found in 9 images.");
  EXPECT_TRUE(json["frame_age_s"].is_null());
  EXPECT_TRUE(json["held_out_curve"].back()["psnr_db"].is_null());
  EXPECT_EQ(json["session_folder"], "caf\xef\xbf\xbd");
}

TEST(StatusJson, ALongCurveIsThinnedAndKeepsItsEnd) {
  MonitorState state;
  for (std::uint64_t n = 1; n <= 100'000; ++n) state.held_out_curve.push_back({.images = n, .psnr_db = 30});
  const auto curve = nlohmann::json::parse(status_json(state, CaptureState::kLive, 0, 0, {}))["held_out_curve"];
  EXPECT_LE(curve.size(), 500U);
  EXPECT_GE(curve.size(), 200U);
  EXPECT_EQ(curve.back()["images"], 100'000);
}

TEST(CaptureState, BeforeTheFirstTrackerItWaits) {
  const auto now = MonitorState::Clock::now();
  MonitorState state;
  state.links = {{.name = "tracker", .endpoint = "tcp://127.0.0.1:7410"}};
  EXPECT_EQ(capture_state(state, now, now), CaptureState::kWaiting) << "nobody is gone who never came";
  state.links[0].came = true;
  EXPECT_EQ(capture_state(state, now, now), CaptureState::kDisconnected);
}

TEST(CaptureState, WhatIsDoneAfterTheLastImageIsNeitherStaleNorEnded) {
  const auto now = MonitorState::Clock::now();
  MonitorState state = sample_monitor_state();
  state.last_frame = now - 60s;
  state.ended = true;
  for (const CaptureState stage :
       {CaptureState::kFinishing, CaptureState::kRefining, CaptureState::kSaving, CaptureState::kJudging}) {
    state.ending = {stage, 3, 9};
    EXPECT_EQ(capture_state(state, now, now), stage);
    const auto json = nlohmann::json::parse(status_json(state, stage, 0, 60, {}));
    EXPECT_EQ(json["state"], to_string(stage));
    EXPECT_EQ(json["ending"]["done"], 3);
    EXPECT_EQ(json["ending"]["total"], 9);
  }
}

TEST(CaptureState, SaysWhatIsTheMatter) {
  const auto now = MonitorState::Clock::now();
  MonitorState state = sample_monitor_state();
  state.last_frame = now - 1s;
  EXPECT_EQ(capture_state(state, now, now), CaptureState::kLive);
  EXPECT_EQ(capture_state(state, now, now + 2500ms), CaptureState::kStale);
  EXPECT_EQ(capture_state(state, now, now + 10s), CaptureState::kStalled);
  state.last_frame.reset();
  EXPECT_EQ(capture_state(state, now, now), CaptureState::kWaiting);
  state.links[0].connected = false;
  EXPECT_EQ(capture_state(state, now, now), CaptureState::kDisconnected);
  state.ended = true;
  EXPECT_EQ(capture_state(state, now, now), CaptureState::kEnded);
  state.error = "the disk is full";
  EXPECT_EQ(capture_state(state, now, now + 10s), CaptureState::kFailed);
}

}  // namespace
}  // namespace sheen
