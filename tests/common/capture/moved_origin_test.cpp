// SPDX-License-Identifier: Apache-2.0
#include "common/capture/moved_origin.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

const Eigen::Vector3d kOrigin(500'123.4, 4'649'776.5, 312.75), kPoint = kOrigin + Eigen::Vector3d(0.3, -0.2, 0.1);
const Rigid3 kPose = look_at(kOrigin + Eigen::Vector3d(1, 2, 3), kOrigin, {0, 0, 1});

TEST(MovedOrigin, ACameraSeesTheSame) {
  const PosedCamera moved = in_frame_at(kOrigin, PosedCamera{{}, kPose});
  EXPECT_LT((moved.camera_from_object * (kPoint - kOrigin) - kPose * kPoint).norm(), 1e-8);
  EXPECT_LT((camera_centre(moved.camera_from_object) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-8);
  EXPECT_EQ(moved.camera_from_object.rotation.coeffs(), kPose.rotation.coeffs());
  const PosedCamera back = in_frame_at(-kOrigin, moved);
  EXPECT_LT((camera_centre(back.camera_from_object) - camera_centre(kPose)).norm(), 1e-8);
}

TEST(MovedOrigin, LightsThatHaveAPlaceAreMoved) {
  const LightState near{.kind = LightKind::kPoint, .position = kPoint};
  const LightState far{.kind = LightKind::kDirectional, .position = {0, 0, 1}};
  EXPECT_EQ(in_frame_at(kOrigin, near).position, kPoint - kOrigin);
  EXPECT_EQ(in_frame_at(kOrigin, far).position, far.position);
  Capture capture;
  capture.light = near;
  capture.pose.camera_from_object = kPose;
  const Capture moved = in_frame_at(kOrigin, capture);
  EXPECT_EQ(moved.light.position, kPoint - kOrigin);
  EXPECT_LT((camera_centre(moved.pose.camera_from_object) - Eigen::Vector3d(1, 2, 3)).norm(), 1e-8);
}

}  // namespace
}  // namespace sheen
