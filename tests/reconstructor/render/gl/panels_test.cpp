// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/panels.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/reconstructor/render/gl/hidden_window.h"

namespace sheen {
namespace {

/// All of the buttons, and nothing told.
class PanelsOverPicture : public Window {
 protected:
  std::vector<ViewAction> lay_out(const Pointer& pointer, int width = kWidth, float scale = 1) {
    return panels().lay_out({state_, controls_, told_, {}, offered_}, width, kHeight, scale, pointer);
  }
  Panels& panels() {
    if (!panels_) panels_.emplace();
    return *panels_;
  }
  std::vector<ViewAction> click(const Eigen::Vector2f& at) {
    lay_out({at, false});
    std::vector<ViewAction> pressed = lay_out({at, true});
    const std::vector<ViewAction> released = lay_out({at, false});
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

}  // namespace
}  // namespace sheen
