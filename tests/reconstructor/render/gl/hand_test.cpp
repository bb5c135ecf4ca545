// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/hand.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

constexpr int kHeight = 100;

struct HandTest : testing::Test {
  Eigen::Vector3d eye() const { return controls.orbit.viewpoint(100, kHeight).eye(); }
  ViewControls controls;
  Hand hand{controls};
};

TEST_F(HandTest, WhatIsPressedOnThePictureMovesItAndWhatIsPressedOnAPanelDoesNot) {
  hand.point({50, 50}, kHeight, {});
  const Eigen::Vector3d before = eye();
  EXPECT_FALSE(hand.point({60, 50}, kHeight, {})) << "nothing is pressed";
  hand.press(Hand::Button::kLeft, true);
  EXPECT_FALSE(hand.point({70, 50}, kHeight, {}));
  EXPECT_EQ(eye(), before);
  EXPECT_TRUE(hand.pointer().pressed);
  hand.looked_at();
  hand.release(Hand::Button::kLeft);
  hand.press(Hand::Button::kLeft, false);
  EXPECT_FALSE(hand.pointer().pressed) << "panels do not see a drag of the picture";
  EXPECT_TRUE(hand.point({80, 50}, kHeight, {}));
  EXPECT_GT((eye() - before).norm(), 0.1);
  EXPECT_NEAR(eye().norm(), before.norm(), 1e-9) << "round the object";
  hand.release(Hand::Button::kLeft);
  EXPECT_FALSE(hand.point({90, 50}, kHeight, {}));
}

TEST_F(HandTest, ShiftAndTheOtherButtonPan) {
  hand.point({50, 50}, kHeight, {});
  for (const auto& [button, shift] : {std::pair{Hand::Button::kOther, false}, {Hand::Button::kLeft, true}}) {
    const Eigen::Vector3d before = eye();
    const Rigid3 turned = controls.orbit.viewpoint(100, kHeight).camera_from_object;
    hand.press(button, false);
    EXPECT_TRUE(hand.point(hand.pointer().at + Eigen::Vector2f(10, 0), kHeight, {.shift = shift}));
    hand.release(button);
    EXPECT_GT((eye() - before).norm(), 0.01);
    EXPECT_TRUE(controls.orbit.viewpoint(100, kHeight).camera_from_object.rotation.isApprox(turned.rotation, 1e-9));
  }
}

TEST_F(HandTest, ArrowsDoWhatTheMouseDoes) {
  const Eigen::Vector3d before = eye();
  EXPECT_TRUE(hand.arrow(3, -2, {}));
  EXPECT_GT((eye() - before).norm(), 0.1);
  EXPECT_TRUE(hand.arrow(-3, 2, {}));
  EXPECT_NEAR((eye() - before).norm(), 0, 1e-9);
  EXPECT_TRUE(hand.come_nearer(2));
  EXPECT_LT(eye().norm(), before.norm());
  EXPECT_TRUE(hand.wheel(-2, false));
  EXPECT_NEAR((eye() - before).norm(), 0, 1e-9);
  EXPECT_FALSE(hand.wheel(1, true)) << "over a panel it scrolls";
  EXPECT_EQ(hand.pointer().wheel, 1);
}

TEST_F(HandTest, MovingEndsFollowing) {
  controls.follow = true;
  controls.light = {0, 0, 1};
  hand.arrow(1, 0, {.control = true});
  EXPECT_TRUE(controls.follow) << "but not turning the light";
  hand.arrow(1, 0, {});
  EXPECT_FALSE(controls.follow);
}

TEST_F(HandTest, ControlTurnsALightThatMoves) {
  const Eigen::Vector3d before = eye();
  hand.arrow(1, 0, {.control = true});
  EXPECT_TRUE(controls.light.isZero()) << "there is none";
  controls.light = (eye() + Eigen::Vector3d(0, 0, 0.1)).normalized();
  const Eigen::Vector3d light = controls.light;
  hand.arrow(1, 0, {.control = true});
  EXPECT_GT((controls.light - light).norm(), 0.01);
  hand.holds_light(true);
  hand.arrow(-1, 0, {});
  EXPECT_NEAR((controls.light - light).norm(), 0, 1e-9);
  EXPECT_EQ(eye(), before);
}

TEST_F(HandTest, AClickThatIsOverBeforeThePanelsLookIsSeen) {
  hand.press(Hand::Button::kLeft, true);
  hand.release(Hand::Button::kLeft);
  EXPECT_TRUE(hand.pointer().pressed);
  EXPECT_TRUE(hand.looked_at()) << "they must look again";
  EXPECT_FALSE(hand.pointer().pressed);
  EXPECT_FALSE(hand.looked_at());
}

}  // namespace
}  // namespace sheen
