// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/frame_ids.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

TEST(FrameIds, GapsAreWhatTheCameraSentAndNobodyGot) {
  EXPECT_EQ(frames_between(1, 2), 0u);
  EXPECT_EQ(frames_between(1, 12), 10u);
  EXPECT_EQ(frames_between(70'000, 70'003), 2u);
}

TEST(FrameIds, ShortIdsGoOnWithOne) {
  EXPECT_EQ(frames_between(65'535, 1), 0u);
  EXPECT_EQ(frames_between(65'530, 3), 7u);
}

TEST(FrameIds, OneThatCameLateIsNoGap) {
  EXPECT_EQ(frames_between(10, 9), 0u);
  EXPECT_EQ(frames_between(10, 10), 0u);
  EXPECT_EQ(frames_between(70'000, 1), 0u) << "the camera began again";
}

}  // namespace
}  // namespace sheen
