// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/panels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <set>

#include "tests/reconstructor/render/gl/hidden_window.h"

namespace sheen {
namespace {

/// All of the buttons, and nothing told.
class PanelsOverPicture : public Window {
 protected:
  PanelEvents lay_out(const Pointer& pointer, int width = kWidth, float scale = 1) {
    return panels().lay_out({state_, controls_, told_, {}, offered_}, width, kHeight, scale, pointer);
  }
  Panels& panels() {
    if (!panels_) panels_.emplace();
    return *panels_;
  }
  std::vector<ViewAction> click(const Eigen::Vector2f& at) {
    lay_out({at, false});
    std::vector<ViewAction> pressed = lay_out({at, true}).pressed;
    const std::vector<ViewAction> released = lay_out({at, false}).pressed;
    pressed.insert(pressed.end(), released.begin(), released.end());
    return pressed;
  }
  std::set<ViewAction> all_that_can_be_clicked() {
    lay_out({});
    std::set<ViewAction> found;
    for (int y = 4; y < kHeight; y += 12)
      for (int x = 4; x < kWidth; x += 12) {
        const Eigen::Vector2f at(static_cast<float>(x), static_cast<float>(y));
        if (!panels().cover(at)) continue;
        const std::vector<ViewAction> pressed = click(at);
        EXPECT_LE(pressed.size(), 1u) << "one click, one action";
        found.insert(pressed.begin(), pressed.end());
      }
    return found;
  }

  ViewerState state_;
  ViewControls controls_;
  Told told_{.sentence = "Waiting for a tracker."};
  std::vector<ViewAction> offered_;
  std::optional<Panels> panels_;  // of the window's context
};

TEST_F(PanelsOverPicture, EveryActionThatIsOfferedHasAButtonAndNoOther) {
  controls_.mode = ViewMode::kSplit;  // in which all of them matter
  for (const ActionWords& words : view_actions()) offered_.push_back(words.action);
  EXPECT_EQ(all_that_can_be_clicked(), std::set<ViewAction>(offered_.begin(), offered_.end()));
  offered_ = {ViewAction::kAppearance, ViewAction::kQuit};
  EXPECT_EQ(all_that_can_be_clicked(), std::set<ViewAction>(offered_.begin(), offered_.end()));
}

TEST_F(PanelsOverPicture, WhatDoesNotShowCannotBeClicked) {
  offered_ = {ViewAction::kReasons, ViewAction::kHelp};
  controls_.mode = ViewMode::kAppearance;
  EXPECT_EQ(all_that_can_be_clicked(), std::set<ViewAction>{ViewAction::kHelp});
}

TEST_F(PanelsOverPicture, CoverWhereTheyAreSeenAndNowhereWhenTheyAreHidden) {
  offered_ = {ViewAction::kAppearance, ViewAction::kQuit};
  lay_out({});
  EXPECT_TRUE(panels().cover({20, 20})) << "what is told first";
  EXPECT_TRUE(panels().cover({kWidth / 2, kHeight - 20})) << "buttons";
  EXPECT_FALSE(panels().cover({kWidth / 2, kHeight / 2}));
  lay_out({}, kWidth, 2);
  EXPECT_TRUE(panels().cover({60, 60})) << "all is larger on a dense screen";
  controls_.panels = false;
  EXPECT_TRUE(all_that_can_be_clicked().empty());
  EXPECT_FALSE(panels().cover({20, 20}));
}

TEST_F(PanelsOverPicture, TheLightGoesWhereTheBallIsPointedAt) {
  const Eigen::Matrix3d axes = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  told_.light = ShownLight{axes, {0, 0, 1}, {}};
  lay_out({});
  EXPECT_FALSE(lay_out({{20, kHeight - 20}, false}).light) << "nothing is pressed";
  // The ball's middle is where the light is the eye's; the rest follows from places round it.
  std::optional<Eigen::Vector2f> middle;
  for (float y = kHeight - 130; y < kHeight && !middle; ++y)
    for (float x = 10; x < 140 && !middle; ++x) {
      lay_out({{x, y}, false});
      const auto light = lay_out({{x, y}, true}).light;
      if (light && (axes * *light).z() > 0.9999) middle = Eigen::Vector2f(x, y);
    }
  ASSERT_TRUE(middle);
  lay_out({*middle, false});
  lay_out({*middle, true});
  const auto light = lay_out({*middle + Eigen::Vector2f(30, -20), true}).light;
  ASSERT_TRUE(light);
  const Eigen::Vector3d seen = axes * *light;
  EXPECT_GT(seen.x(), 0.3);
  EXPECT_NEAR(seen.y() / seen.x(), 20.0 / 30, 0.1);
  const auto far = lay_out({{kWidth - 1, middle->y()}, true}).light;
  ASSERT_TRUE(far) << "a drag may leave the ball";
  EXPECT_GT((axes * *far).x(), 0.99);
  EXPECT_GT((axes * *far).z(), 0);
}

}  // namespace
}  // namespace sheen
