// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/camera_moves.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

const LookAt kFirst{{0.4, 0.1, 0.3}, {0.1, 0.1, 0}, {0, 0, 1}};

double angle(const LookAt& a, const LookAt& b) {
  const Vector3d p = a.eye - a.target, q = b.eye - b.target;
  return std::atan2(p.cross(q).norm(), p.dot(q));
}

TEST(CameraMoves, ATurntableComesBackOneStepBehindItsLastFrame) {
  const std::vector<LookAt> views = turntable(kFirst, 24);
  ASSERT_EQ(views.size(), 24u);
  EXPECT_EQ(views[0].eye, kFirst.eye);
  const double step = angle(views[0], views[1]);
  for (std::size_t i = 0; i < views.size(); ++i) {
    EXPECT_NEAR(angle(views[i], views[(i + 1) % 24]), step, 1e-9);
    EXPECT_NEAR(views[i].eye.z(), kFirst.eye.z(), 1e-12);
    EXPECT_EQ(views[i].target, kFirst.target);
  }
  EXPECT_NEAR((views[12].eye - Vector3d(-0.2, 0.1, 0.3)).norm(), 0, 1e-12) << "half way round: opposite";
}

TEST(CameraMoves, ASwingStaysBeforeTheObjectAndClosesItself) {
  const std::vector<LookAt> views = swing(kFirst, 60);
  EXPECT_NEAR((views[0].eye - kFirst.eye).norm(), 0, 1e-12);
  EXPECT_NEAR((views[30].eye - kFirst.eye).norm(), 0, 1e-12) << "the middle of the eight";
  double farthest = 0, step = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    farthest = std::max(farthest, angle(views[0], views[i]));
    step = std::max(step, angle(views[i], views[(i + 1) % 60]));
    EXPECT_NEAR((views[i].eye - views[i].target).norm(), (kFirst.eye - kFirst.target).norm(), 1e-12);
  }
  EXPECT_GT(farthest, 15 * std::numbers::pi / 180);
  EXPECT_LT(farthest, 35 * std::numbers::pi / 180);
  EXPECT_LT(step, 5 * std::numbers::pi / 180) << "the last frame leads to the first";
}

TEST(CameraMoves, ASwingFromStraightAbove) {
  for (const LookAt& view : swing({{0, 0, 1}, {0, 0, 0}, {0, 0, 1}}, 16)) EXPECT_TRUE(view.eye.allFinite());
}

TEST(CameraMoves, APathMeetsItsKeys) {
  const std::vector<LookAt> keys = {{{1, 0, 0}, {0, 0, 0}}, {{0, 1, 1}, {0, 0, 0.1}}, {{-1, 0, 0}, {0, 0, 0}}};
  const std::vector<LookAt> open = through(keys, 21, false), closed = through(keys, 30, true);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR((open[10 * k].eye - keys[k].eye).norm(), 0, 1e-12);
    EXPECT_NEAR((open[10 * k].target - keys[k].target).norm(), 0, 1e-12);
    EXPECT_NEAR((closed[10 * k].eye - keys[k].eye).norm(), 0, 1e-12);
  }
  EXPECT_EQ(open.size(), 21u);
  EXPECT_EQ(closed.size(), 30u);
  EXPECT_GT((closed[29].eye - closed[0].eye).norm(), 0.01);
  EXPECT_LT((closed[29].eye - closed[0].eye).norm(), 0.4) << "one step";
}

TEST(CameraMoves, TheObjectIsInThePictureAndFillsIt) {
  const Mesh mesh = sphere_mesh(0.1f, 3);
  const std::vector<PosedCamera> cameras = framed(turntable({{0.5, 0, 0.1}, {0, 0, 0}}, 7), mesh, {320, 180});
  double highest = 90;
  for (const PosedCamera& from : cameras) {
    EXPECT_EQ(from.camera.fx, cameras[0].camera.fx) << "no zoom";
    for (const Eigen::Vector3f& vertex : mesh.vertices) {
      const auto pixel = from.camera.project(from.camera_from_object * vertex.cast<double>());
      ASSERT_TRUE(pixel && from.camera.contains(*pixel));
      highest = std::min(highest, pixel->y());
    }
  }
  EXPECT_NEAR(highest, 89.5 - 0.9 * 90, 0.01);
  const PosedCamera wide = with_field(turntable(kFirst, 2), 90, {320, 180})[0];
  EXPECT_NEAR(wide.camera.fy, 90, 1e-9);
}

}  // namespace
}  // namespace sheen
