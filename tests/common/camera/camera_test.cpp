// SPDX-License-Identifier: Apache-2.0
#include "common/camera/camera.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/camera/rigid3.h"

namespace sheen {
namespace {

Camera test_camera() {
  return {.width = 1024, .height = 768, .fx = 1200, .fy = 1190, .cx = 511.5, .cy = 380};
}

TEST(Camera, PinholeProjectsByHand) {
  const auto p = test_camera().project({0.1, -0.2, 2});
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->x(), 511.5 + 1200 * 0.05, 1e-12);
  EXPECT_NEAR(p->y(), 380 - 1190 * 0.1, 1e-12);
}

TEST(Camera, BrownConradyMatchesItsFormula) {
  Camera c = test_camera();
  c.distortion = {-0.2, 0.05, 0.001, -0.002, 0.01};
  const double x = 0.15, y = -0.1, r2 = x * x + y * y;
  const double radial = 1 - 0.2 * r2 + 0.05 * r2 * r2 + 0.01 * r2 * r2 * r2;
  const double xd = x * radial + 2 * 0.001 * x * y - 0.002 * (r2 + 2 * x * x);
  const double yd = y * radial + 0.001 * (r2 + 2 * y * y) - 2 * 0.002 * x * y;
  const auto p = c.project({x, y, 1});
  ASSERT_TRUE(p);
  EXPECT_NEAR(p->x(), c.fx * xd + c.cx, 1e-9);
  EXPECT_NEAR(p->y(), c.fy * yd + c.cy, 1e-9);
}

TEST(Camera, RayInvertsProjectThroughEveryLens) {
  Camera brown = test_camera(), fisheye = test_camera();
  brown.distortion = {-0.25, 0.08, 0.001, -0.0015, 0.0};
  fisheye.lens = LensModel::kFisheye;
  fisheye.distortion = {0.02, -0.01, 0.003, -0.001, 0};
  for (const Camera& c : {test_camera(), brown, fisheye})
    for (double v = 0; v < c.height; v += 95.9)
      for (double u = 0; u < c.width; u += 102.3) {
        const auto ray = c.ray({u, v});
        ASSERT_TRUE(ray);
        EXPECT_NEAR(ray->norm(), 1, 1e-12);
        const auto back = c.project(*ray * 3.7);
        ASSERT_TRUE(back);
        EXPECT_NEAR(back->x(), u, 1e-7);
        EXPECT_NEAR(back->y(), v, 1e-7);
      }
}

TEST(Camera, NothingBehindTheCameraAndNothingPastTheFold) {
  Camera c = test_camera();
  EXPECT_FALSE(c.project({0, 0, -1}));
  EXPECT_FALSE(c.project({0, 0, 0}));
  c.distortion = {-0.5, 0, 0, 0, 0};  // folds where 1 = 3 * 0.5 r^2, r = 0.816
  EXPECT_TRUE(c.project({0.8, 0, 1}));
  EXPECT_FALSE(c.project({0.83, 0, 1}));
  EXPECT_FALSE(c.project({1.4, 0, 1})) << "the polynomial is back near the centre there";
}

TEST(Camera, ScalingKeepsPixelCentres) {
  const Camera c = test_camera(), half = c.scaled(512, 384);
  const Eigen::Vector3d point(0.11, 0.07, 1.3);
  const Eigen::Vector2d full_px = *c.project(point), half_px = *half.project(point);
  EXPECT_NEAR(half_px.x(), (full_px.x() + 0.5) / 2 - 0.5, 1e-12);
  EXPECT_NEAR(half_px.y(), (full_px.y() + 0.5) / 2 - 0.5, 1e-12);
}

TEST(Camera, ValidationNamesTheField) {
  Camera c = test_camera();
  EXPECT_EQ(validation_error(c), "");
  c.fy = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(validation_error(c).find("fy"), std::string::npos);
}

TEST(LookAt, PutsTheTargetInFrontAndUpInTheImage) {
  const Rigid3 pose = look_at({1, 2, 3}, {0.2, 0.1, 0}, {0, 0, 1});
  const Eigen::Vector3d target = pose * Eigen::Vector3d(0.2, 0.1, 0);
  EXPECT_NEAR(target.x(), 0, 1e-12);
  EXPECT_NEAR(target.y(), 0, 1e-12);
  EXPECT_GT(target.z(), 0);
  EXPECT_LT((pose.rotation * Eigen::Vector3d(0, 0, 1)).y(), 0) << "y runs down in the image";
  EXPECT_NEAR((camera_centre(pose) - Eigen::Vector3d(1, 2, 3)).norm(), 0, 1e-12);
  const Rigid3 down = look_at({0, 0, 1}, {0, 0, 0}, {0, 0, 1});
  EXPECT_TRUE(down.matrix().allFinite()) << "straight down, where up says nothing";
}

}  // namespace
}  // namespace sheen
