// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/live_display.h"

#include <gtest/gtest.h>

#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

TEST(LiveDisplay, SaysWhetherImagesAreStillToCome) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  const RayPainter painter(mesh);
  LiveDisplay display(painter, {});
  const auto shown = [&](const LoopStatus& status) {
    display.publish_to_window(status);
    return display.feed().latest()->link;
  };
  LoopStatus status;
  EXPECT_EQ(shown(status), TrackerLink::kWaiting);
  status.link.ended = true;
  EXPECT_EQ(shown(status), TrackerLink::kEnded) << "not a saved model that is looked at";
}

TEST(LiveDisplay, WhatIsReceivedIsUsedRefusedTakenBackOrWaits) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  const RayPainter painter(mesh);
  LiveDisplay display(painter, {});
  LoopStatus status;
  status.journaled = 20;
  status.ingested = 12;
  status.counts = {.received = 12, .accepted = 7, .held_out = 1, .refused = {{"no_pose", 3}}, .withdrawn = 1};
  display.publish_to_window(status);
  const CaptureFigures shown = *display.feed().latest()->figures;
  EXPECT_EQ(shown.frames_received, 20u);
  EXPECT_EQ(shown.frames_waiting, 8u);
  EXPECT_EQ(shown.frames_received,
            shown.frames_accepted + shown.frames_refused.at("no_pose") + shown.frames_withdrawn + shown.frames_waiting);
  const MonitorState page = display.monitor_state(status);
  EXPECT_EQ(page.received, 20u);
  EXPECT_EQ(page.received, page.accepted + page.held_out + page.refused.at("no_pose") + page.withdrawn + page.waiting);
}

TEST(LiveDisplay, FinishingSavingAndJudgingAreStatesWithABar) {
  const Mesh mesh = square_mesh(0.1f, 0, 1);
  const RayPainter painter(mesh);
  LiveDisplay display(painter, {});
  const auto long_ago = MonitorState::Clock::now() - std::chrono::minutes(1);
  const auto expect = [&](EndStage stage, CaptureState state, const std::string& word) {
    const EndProgress end{stage, 3, 12};
    display.publish_to_window({}, end);
    const auto window = display.feed().latest();
    ASSERT_TRUE(window->work);
    EXPECT_EQ(window->work->what.substr(0, word.size()), word);
    EXPECT_EQ(window->work->share, 0.25);
    EXPECT_EQ(window->link, TrackerLink::kEnded) << "not a tracker that fell silent";
    MonitorState page = display.monitor_state({}, end);
    page.last_frame = long_ago;
    EXPECT_EQ(capture_state(page, MonitorState::Clock::now(), MonitorState::Clock::now()), state);
    EXPECT_EQ(page.ending->done, 3u);
    EXPECT_EQ(page.ending->total, 12u);
  };
  expect(EndStage::kFinishing, CaptureState::kFinishing, "FINISHING: image 3 of 12");
  expect(EndStage::kSaving, CaptureState::kSaving, "SAVING");
  expect(EndStage::kJudging, CaptureState::kJudging, "JUDGING");
  display.publish_to_window({});
  EXPECT_FALSE(display.feed().latest()->work);
}

}  // namespace
}  // namespace sheen
