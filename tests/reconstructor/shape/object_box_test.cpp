// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/object_box.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/analytic_scene.h"
#include "tests/support/expect_error.h"

namespace sheen {
namespace {

const Camera kCamera{.width = 200, .height = 200, .fx = 400, .fy = 400, .cx = 99.5, .cy = 99.5};

std::vector<PosedCamera> round(const Eigen::Vector3d& place, int count) {
  std::vector<PosedCamera> cameras;
  for (const Eigen::Vector3d& eye : analytic::eyes(count, 0.5, -0.9))
    cameras.push_back({kCamera, look_at(place + eye, place, Eigen::Vector3d::UnitZ())});
  return cameras;
}

TEST(BoxSeenBy, LiesRoundWhatTheCamerasLookAt) {
  const Eigen::Vector3d place(3, -2, 7);
  const Eigen::AlignedBox3d box = box_seen_by(0.5, round(place, 30));
  // Within the frame at the middle: half a picture's width over the focal length, times the distance.
  const double half = 100.0 / 400 * 0.5;
  EXPECT_LT((box.center() - place).norm(), 0.02);
  EXPECT_TRUE((box.sizes().array() > 1.6 * half).all()) << box.sizes();
  EXPECT_TRUE((box.sizes().array() < 3.2 * half).all()) << box.sizes();
}

TEST(BoxSeenBy, IsNotMovedByAFewThatLookElsewhere) {
  const Eigen::Vector3d place(0, 0, 0);
  std::vector<PosedCamera> cameras = round(place, 30);
  for (int i = 0; i < 6; ++i)
    cameras[5 * i].camera_from_object =
        look_at(camera_centre(cameras[5 * i].camera_from_object), {5, 5, 0}, Eigen::Vector3d::UnitZ());
  EXPECT_LT((box_seen_by(0.5, cameras).center() - place).norm(), 0.03);
}

TEST(BoxSeenBy, RefusesParallelAxes) {
  std::vector<PosedCamera> cameras(5, {kCamera, {}});
  for (int i = 0; i < 5; ++i) cameras[i].camera_from_object.translation = {0.1 * i, 0.02 * i * i, 0};
  expect_error<Error>([&] { box_seen_by(0.5, cameras); }, {"look in parallel", "several sides"});
}

TEST(PartWith, HoldsTheBoxWithinTheImage) {
  const PosedCamera camera{kCamera, look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY())};
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-0.1, -0.05, 0), Eigen::Vector3d(0.1, 0.05, 0.5));
  const PixelBox part = part_with(box, camera);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    const Eigen::Vector2d pixel = *kCamera.project(camera.camera_from_object * p);
    EXPECT_GE(pixel.x(), part.x0);
    EXPECT_LE(pixel.x(), part.x1);
    EXPECT_GE(pixel.y(), part.y0);
    EXPECT_LE(pixel.y(), part.y1);
  }
  EXPECT_LE(part.width(), 163);
  const Eigen::AlignedBox3d beside(Eigen::Vector3d(5, 5, 0), Eigen::Vector3d(6, 6, 0.1));
  EXPECT_TRUE(part_with(beside, camera).empty());
}

}  // namespace
}  // namespace sheen
