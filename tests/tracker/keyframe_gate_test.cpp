// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/keyframe_gate.h"

#include <gtest/gtest.h>

#include "tests/tracker/synthetic_stage.h"

namespace sheen {
namespace {

class Gate : public ::testing::Test {
 protected:
  Gate() {
    pose.status = PoseStatus::kTracked;
    pose.camera_from_object = look_at({0, 0, 0.6}, {0, 0, 0}, {0, 1, 0});
    pose.tags_used = 12;
    image = {.format = PixelFormat::kMono8, .width = 1024, .height = 768, .stride = 1024};
    image.bytes.assign(1024 * 768, 120);
  }
  FrameVerdict judge() const { return gate.judge(camera, image, true, pose); }

  const Camera camera = testing::stage_camera(true);
  const ObjectRegion region = object_region(make_stage({}));
  KeyframeGate gate{GateOptions{}, region};
  PoseEstimate pose;
  RawImage image;
};

TEST_F(Gate, TakesAGoodFrame) {
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
}

TEST_F(Gate, NamesEachReason) {
  EXPECT_EQ(gate.judge(camera, image, false, pose), FrameVerdict::kIncomplete);
  pose.status = PoseStatus::kInconsistent;
  EXPECT_EQ(judge(), FrameVerdict::kNoPose);
  pose.status = PoseStatus::kTracked;
  pose.tags_used = 5;
  EXPECT_EQ(judge(), FrameVerdict::kTooFewTags);
  pose.tags_used = 6;
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
  pose.blur_px = 2.01;
  EXPECT_EQ(judge(), FrameVerdict::kMotionBlur);
  pose.blur_px = 1.99;
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
  image.bytes.assign(image.bytes.size(), 255);
  EXPECT_EQ(judge(), FrameVerdict::kOverexposed);
  image.bytes.assign(image.bytes.size(), 20);
  EXPECT_EQ(judge(), FrameVerdict::kUnderexposed);
}

TEST_F(Gate, ExposureCountsOnTheObjectOnly) {
  for (int y = 0; y < 768; ++y)
    for (int x = 0; x < 1024; ++x)
      if (x < 250 || x > 780 || y < 100 || y > 660) image.bytes[y * 1024 + x] = 255;  // a bright room
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
}

/// A camera 0.6 m away: sideways uncertainty s moves the picture of the object (nearest point 0.45 m) by f s / z.
TEST_F(Gate, JudgesUncertaintyByItsEffectOnTheObject) {
  pose.covariance.setZero();
  pose.covariance(3, 3) = 1e-5 * 1e-5;  // 0.027 px at 0.45 m
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
  pose.covariance(3, 3) = 3e-5 * 3e-5;  // 0.08 px
  EXPECT_EQ(judge(), FrameVerdict::kUncertainPose);
}

TEST_F(Gate, ForgetsNoKeyframe) {
  gate.remember(pose);
  EXPECT_EQ(judge(), FrameVerdict::kTooNear);
  pose.camera_from_object = look_at({0.003, 0, 0.6}, {0, 0, 0}, {0, 1, 0});
  EXPECT_EQ(judge(), FrameVerdict::kTooNear);
  pose.camera_from_object = look_at({0.02, 0, 0.6}, {0, 0, 0}, {0, 1, 0});  // 2 degrees round
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
  pose.camera_from_object = look_at({0, 0, 0.62}, {0, 0, 0}, {0, 1, 0});  // farther along the same direction
  EXPECT_EQ(judge(), FrameVerdict::kKeyframe);
}

/// Sideways at v the picture of a point at depth z moves by f v t / z; the nearest point of the region counts.
TEST_F(Gate, PredictsTheStreakOfASidewaysMotion) {
  const Rigid3 before{Eigen::Quaterniond::Identity(), {0, 0, 0.6}}, now{Eigen::Quaterniond::Identity(), {0.01, 0, 0.6}};
  const double nearest = 0.6 + region.centre.z() - region.radius_m;
  EXPECT_NEAR(predicted_blur_px(camera, region, before, now, 0.1, 0.005), 1200 * 0.1 * 0.005 / nearest, 1e-6);
  BlurPredictor predictor;
  EXPECT_EQ(predictor.predict(camera, region, before, 0, 0.005), 0);
  EXPECT_NEAR(predictor.predict(camera, region, now, 100'000'000, 0.005), 1200 * 0.1 * 0.005 / nearest, 1e-6);
  EXPECT_EQ(predictor.predict(camera, region, before, 700'000'000, 0.005), 0);  // too long ago to know
  EXPECT_EQ(predictor.predict(camera, region, now, 700'000'000, 0.005), 0);     // no time has passed
}

TEST(GateOptions, NamesTheBrokenOption) {
  EXPECT_EQ(validation_error(GateOptions{}), "");
  EXPECT_NE(validation_error(GateOptions{.min_tags = 1}).find("min_tags"), std::string::npos);
  EXPECT_NE(validation_error(GateOptions{.max_blur_px = -1}).find("max_blur_px"), std::string::npos);
  EXPECT_NE(validation_error(GateOptions{.max_overexposed = 2}).find("max_overexposed"), std::string::npos);
}

}  // namespace
}  // namespace sheen
