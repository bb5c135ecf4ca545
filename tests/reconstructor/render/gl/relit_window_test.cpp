// SPDX-License-Identifier: Apache-2.0
// The window shows a model of moving light in the light that the controls have.
#include <gtest/gtest.h>

#include "reconstructor/models/irradiance_field/kind.h"
#include "tests/reconstructor/models/irradiance_field/lambertian_relief.h"
#include "tests/reconstructor/render/gl/hidden_window.h"

namespace sheen {
namespace {

class RelitWindow : public testing::Test {
 protected:
  void SetUp() override {
    try {
      window_.emplace(irradiance_field_kind(),
                      ViewerOptions{.width = relief_.width, .height = relief_.height, .visible = false, .samples = 1});
    } catch (const DeviceError& error) {
      GTEST_SKIP() << error.what();
    }
    window_->controls().panels = false;
    state_.snapshot = snapshot_;
  }

  const LambertianRelief relief_{};
  const std::shared_ptr<const IrradianceFieldSnapshot> snapshot_ =
      std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(relief_.model(dome_of_lights())->snapshot());
  ViewerState state_;
  std::optional<ViewerWindow> window_;
};

TEST_F(RelitWindow, OpensInALightOfTheImagesFromTheUpperLeft) {
  window_->draw_once(state_);
  const Eigen::Vector3d light = window_->controls().light;
  const auto lights = dome_of_lights();
  EXPECT_TRUE(std::any_of(lights.begin(), lights.end(), [&](const auto& one) { return one.isApprox(light, 1e-6); }));
  const Eigen::Vector3d seen = relief_.camera().camera_from_object.rotation * light;  // right, down, into the picture
  EXPECT_LT(seen.x(), 0);
  EXPECT_LT(seen.y(), 0);
  EXPECT_LT(seen.z(), 0);
}

TEST_F(RelitWindow, ShowsTheModelsPictureInTheChosenLight) {
  window_->draw_once(state_);
  for (const Eigen::Vector3d& light : {Eigen::Vector3d(0.3, 0.2, 1).normalized(), {0, 0, 1}}) {
    window_->controls().light = light;
    const ImageU8 shown = window_->draw_once(state_);
    const ImageU8 expected = snapshot_->screen_picture({.kind = LightKind::kDirectional, .position = light});
    EXPECT_LE(largest_difference(shown, expected), 1);
  }
}

TEST_F(RelitWindow, ResetBringsTheFirstLightBack) {
  const ImageU8 first = window_->draw_once(state_);
  window_->controls().turn_light(0.5, -0.3);
  EXPECT_GT(largest_difference(window_->draw_once(state_), first), 5);
  window_->controls().reset();
  EXPECT_EQ(largest_difference(window_->draw_once(state_), first), 0);
}

}  // namespace
}  // namespace sheen
