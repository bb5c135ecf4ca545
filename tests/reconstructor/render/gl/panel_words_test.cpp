// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/panel_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sheen {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const SnapshotFigures kFigures{.median_rank = 3, .most_rank = 6, .seen = 0.889, .measured = 0.7};

Told told_of(const ViewerState& state, const Guidance* guidance = nullptr) {
  return told(state, {}, {.model = "surface light field", .figures = &kFigures, .guidance = guidance}, {});
}

TEST(Told, TheSentenceSaysHowFarACaptureIs) {
  ViewerState state;
  state.link = TrackerLink::kConnected;
  EXPECT_EQ(told_of(state).sentence, "88 % of the surface is seen.") << "never more than there is";
  EXPECT_EQ(told_of(state).tone, Tone::kGood);
  EXPECT_EQ(told(state, {}, {.model = ""}, {}).sentence, "Images arrive.");
  state.next_view = NextView{.reason = "33 dB are expected even from the least known place", .well_known = true};
  EXPECT_EQ(told_of(state).sentence, "All of it is well known.");
  EXPECT_EQ(told_of(state).next, "Done: 33 dB are expected even from the least known place");
  state.link = TrackerLink::kEnded;
  EXPECT_EQ(told_of(state).sentence, "All images have come. All of it is well known.");
  state.link = TrackerLink::kStale;
  EXPECT_EQ(told_of(state).tone, Tone::kWarn);
  state.link = TrackerLink::kConnected;
  state.trouble = "too fast: motion blur";
  EXPECT_EQ(told_of(state).tone, Tone::kBad);
  state.paused = true;
  EXPECT_EQ(told_of(state).sentence, "Paused: images are stored, but not added to the model.");
  EXPECT_EQ(told_of(state).tone, Tone::kWarn);
  state.work = WorkInHand{"SAVING the model", 0.2, "Q: end now, without the model"};
  EXPECT_EQ(told_of(state).sentence, "SAVING the model");
  EXPECT_EQ(told_of(state).next, "Q: end now, without the model");
  EXPECT_EQ(told_of({}).sentence, "There is no model.");
}

TEST(Told, TheWayIsThatOfTheWords) {
  ViewerState state;
  state.link = TrackerLink::kConnected;
  state.next_view = NextView{.reason = "no image from near here"};
  const Guidance left{-30, 40}, here{1, 1};
  EXPECT_EQ(told_of(state, &left).next, "Next: move 30 degrees to the left, 40 up: no image from near here");
  ASSERT_TRUE(told_of(state, &left).way);
  EXPECT_TRUE(told_of(state, &left).way->isApprox(Eigen::Vector2f(-0.6f, 0.8f)));
  EXPECT_EQ(told_of(state, &here).next, "Next: here, hold still: no image from near here");
  EXPECT_TRUE(told_of(state, &here).way->isZero());
  EXPECT_FALSE(told_of(state).way) << "without a model there is nowhere to go";
  state.next_view.reset();
  state.figures = CaptureFigures{.frames_waiting = 9};
  EXPECT_EQ(told_of(state).next, "The model catches up: 9 images wait.");
}

TEST(Told, TheRestInALine) {
  ViewerState state;
  state.link = TrackerLink::kConnected;
  state.figures =
      CaptureFigures{.frames_accepted = 12, .frames_held_out = 2, .frames_waiting = 3, .held_out_psnr_db = 31.24};
  EXPECT_EQ(told_of(state).counts,
            "10 images in the model \xc2\xb7 31.2 dB on views it never saw \xc2\xb7 3 wait to be added");
  state.figures = CaptureFigures{.frames_accepted = 1};
  EXPECT_EQ(told_of(state).counts, "1 image in the model");
}

TEST(Told, WhatIsNotKeptIsANoteToo) {
  ViewerState state;
  state.figures = CaptureFigures{.trade = {.image_ms = 30, .budget_ms = 33}};
  EXPECT_THAT(told_of(state).notes, IsEmpty());
  state.figures->trade.image_ms = 40;
  EXPECT_THAT(told_of(state).notes, ElementsAre(HasSubstr("NOT KEPT")));
  state.message = "start a tracker";
  EXPECT_THAT(told_of(state).notes, ElementsAre("start a tracker", HasSubstr("budget: 40.0 of 33 ms per image")));
}

}  // namespace
}  // namespace sheen
