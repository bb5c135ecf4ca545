// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/build_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace sheen {
namespace {

using ::testing::HasSubstr;

Reconstruction::Judgement judged(double model_db, double constant_db) {
  Reconstruction::Judgement judgement;
  judgement.model.psnr_db = model_db;
  judgement.constant.psnr_db = constant_db;
  return judgement;
}

TEST(BuildVerdict, AModelWorseThanOneColourIsWorthlessUnlessBothAreGood) {
  EXPECT_THAT(worthless(judged(8.54, 8.72)),
              HasSubstr("worse (8.54 dB) than one colour for each place does (8.72 dB)"));
  EXPECT_EQ(worthless(judged(8.72, 8.54)), "");
  EXPECT_EQ(worthless(judged(18.49, 18.52)), "") << "chance";
  EXPECT_EQ(worthless(judged(38.1, 38.3)), "") << "a matt object looks the same from everywhere";
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(worthless(judged(none, none)), "") << "no view was held out";
}

TEST(BuildVerdict, MostImagesUnusedIsSaidWithTheCommonestReason) {
  FrameCounts counts{.received = 30, .accepted = 9, .held_out = 4, .refused = {{"off_object", 8}, {"no_pose", 9}}};
  EXPECT_THAT(mostly_unused(counts), HasSubstr("17 of 26 images could not be used, most of them because: no_pose"));
  counts.accepted = 17;
  EXPECT_EQ(mostly_unused(counts), "");
}

}  // namespace
}  // namespace sheen
