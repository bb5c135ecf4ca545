// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/light_rig.h"

#include <gtest/gtest.h>

#include "common/base/errors.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

/// What the pixels of a rig show, in closed form.
class LightRigTest : public ::testing::Test {
 protected:
  /// Where the ray through a pixel's centre meets the plane z = 0, as depth along the camera's axis and point.
  static std::pair<double, Vector3d> on_ground(const PosedCamera& from, int x, int y) {
    const Rigid3 object_from_camera = from.camera_from_object.inverse();
    const Vector3d ray = object_from_camera.rotation *
                         Vector3d((x - from.camera.cx) / from.camera.fx, (y - from.camera.cy) / from.camera.fy, 1);
    const double depth = -object_from_camera.translation.z() / ray.z();
    return {depth, object_from_camera.translation + depth * ray};
  }
  /// Distance of a point of the ground from the shadow of the rod's axis, as its lamp casts it, and the place along it:
  /// 0 at the rod's foot, 1 at the shadow of its top.
  static std::pair<double, double> from_rods_shadow(const Vector3d& lamp, const Vector3d& point) {
    const Vector3d foot(kRodPlace.x(), kRodPlace.y(), 0), top = foot + Vector3d(0, 0, kRodHeight);
    const Vector3d tip = lamp + (top - lamp) * (lamp.z() / (lamp.z() - top.z()));
    const Vector3d along = tip - foot;
    const double t = (point - foot).dot(along) / along.squaredNorm();
    return {(point - foot - t * along).norm(), t};
  }

  const LightRig rig_{{.lights = 5, .columns = 3, .rows = 1, .width = 240, .height = 180}};
};

TEST_F(LightRigTest, TheGroundIsAPlaneInMovingLight) {
  const PosedCamera from = rig_.cameras().front();
  const LightState& light = rig_.lights()[1];
  const SimulatedPicture picture = rig_.picture(from, light);
  std::size_t lit = 0, shadowed = 0;
  for (int y = 1; y + 1 < 180; ++y)
    for (int x = 1; x + 1 < 240; ++x) {
      const auto [depth, point] = on_ground(from, x, y);
      if (std::abs(picture.depth.at(x, y) - depth) > 1e-5) continue;
      const Vector3d to_lamp = light.position - point;
      const double d = to_lamp.norm(), cosine = to_lamp.z() / d, falloff = light.position.squaredNorm() / (d * d);
      bool uniform = true;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          uniform &= picture.shadow.at(u, v) == picture.shadow.at(x, y) &&
                     std::abs(picture.depth.at(u, v) - on_ground(from, u, v).first) < 1e-5;
      if (!uniform) continue;
      const bool dark = picture.shadow.at(x, y) != 0;
      ++(dark ? shadowed : lit);
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(picture.radiance.at(x, y, c),
                    picture.reflectance.at(x, y, c) * (LightRig::kAmbient + (dark ? 0 : cosine * falloff)), 2e-5);
    }
  EXPECT_GT(lit, 20000u);
  EXPECT_GT(shadowed, 800u);
}

TEST_F(LightRigTest, TheRodsShadowIsWhereItMustBe) {
  const PosedCamera from = rig_.central_camera();
  const Vector3d lamp = rig_.lights()[2].position;
  const SimulatedPicture picture = rig_.picture(from, rig_.lights()[2]);
  std::size_t inside = 0, beside = 0;
  for (int y = 0; y < 180; ++y)
    for (int x = 0; x < 240; ++x) {
      const auto [depth, point] = on_ground(from, x, y);
      if (std::abs(picture.depth.at(x, y) - depth) > 1e-5) continue;
      const auto [distance, along] = from_rods_shadow(lamp, point);
      if (along < 0.2 || along > 0.9) continue;
      // The shadow of an upright rod is as wide as the rod, and a little wider far from a lamp that is near.
      if (distance < kRodRadius) {
        ++inside;
        EXPECT_EQ(picture.shadow.at(x, y), 255) << x << ", " << y;
      } else if (distance > 1.2 * kRodRadius && distance < 3 * kRodRadius) {
        ++beside;
        EXPECT_EQ(picture.shadow.at(x, y), 0) << x << ", " << y;
      }
    }
  EXPECT_GT(inside, 100u);
  EXPECT_GT(beside, 150u);
}

TEST_F(LightRigTest, MidwayLampsLieHalfwayRoundTheCircle) {
  ASSERT_EQ(rig_.midway_lights().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector3d a = rig_.lights()[i].position, b = rig_.lights()[i + 1].position,
                   m = rig_.midway_lights()[i].position;
    EXPECT_NEAR((m - a).norm(), (m - b).norm(), 1e-12);
    EXPECT_NEAR(m.norm(), a.norm(), 1e-12);
  }
}

TEST(LightRigOptionsTest, AreChecked) {
  EXPECT_THROW(LightRig({.lights = 1}), ConfigError);
  EXPECT_THROW(LightRig({.columns = 0}), ConfigError);
  EXPECT_THROW(LightRig({.width = 8}), ConfigError);
  EXPECT_THROW(LightRig({.gloss = 2}), ConfigError);
}

}  // namespace
}  // namespace sheen
