// SPDX-License-Identifier: Apache-2.0
// A scene in closed form, photographed through a lens and without one.
#include "reconstructor/radiance/undistortion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

/// Light from a direction: waves a dozen pixels long.
Eigen::Vector3f light_from(const Eigen::Vector3d& ray) {
  const double x = ray.x() / ray.z(), y = ray.y() / ray.z();
  return Eigen::Vector3d(1 + std::sin(40 * x), 1 + std::cos(40 * y), 1 + std::sin(25 * (x + y))).cast<float>() / 2;
}

/// 0 where the lens has no ray.
ImageF photograph(const Camera& camera) {
  ImageF picture(camera.width, camera.height, 3);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if (const auto ray = camera.ray(Eigen::Vector2d(x, y)))
        Eigen::Map<Eigen::Vector3f>(picture.pixel(x, y)) = light_from(*ray);
  return picture;
}

void expect_as_a_pinhole_sees_it(const Camera& camera) {
  const UndistortedPicture out = undistorted(camera, photograph(camera), {});
  ASSERT_TRUE(out.camera.is_pinhole());
  EXPECT_EQ(out.camera.fx, camera.fx);
  EXPECT_EQ(out.camera.cy, camera.cy);
  const ImageF truth = photograph(out.camera);
  int counted = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const bool counts = out.mask.empty() || out.mask.at(x, y) == 255;
      counted += counts;
      for (int c = 0; c < 3; ++c) {
        const float off = std::abs(out.linear.at(x, y, c) - truth.at(x, y, c));
        const bool inside = x > 2 && y > 2 && x + 3 < camera.width && y + 3 < camera.height;
        if (counts && inside) ASSERT_LT(off, 0.02f) << x << " " << y;
        if (!counts) ASSERT_EQ(out.linear.at(x, y, c), 0);
      }
    }
  EXPECT_GT(counted, camera.width * camera.height / 2);
}

const Camera kPinhole{.width = 160, .height = 120, .fx = 150, .fy = 152, .cx = 81, .cy = 58.5};

TEST(Undistortion, IsWhatAPinholeSees) {
  Camera barrel = kPinhole, cushion = kPinhole, fisheye = kPinhole;
  barrel.distortion = {-0.2, 0.05, 2e-3, -1e-3, 0.01};
  cushion.distortion = {0.2, 0, 0, 0, 0};
  fisheye.lens = LensModel::kFisheye;
  fisheye.distortion = {0.02, -0.01, 0, 0, 0};
  for (const Camera& camera : {kPinhole, barrel, cushion, fisheye}) expect_as_a_pinhole_sees_it(camera);
}

TEST(Undistortion, TheMaskGoesWithIt) {
  Camera cushion = kPinhole;
  cushion.distortion = {0.2, 0, 0, 0, 0};
  const ImageF picture = photograph(cushion);
  const ImageU8 beyond = undistorted(cushion, picture, {}).mask;
  ASSERT_FALSE(beyond.empty());
  EXPECT_EQ(beyond.at(0, 0), 0) << "the lens showed nothing of it";
  EXPECT_EQ(beyond.at(81, 58), 255);
  ImageU8 mask(cushion.width, cushion.height, 1, 255);
  const auto where = cushion.project({(30 - cushion.cx) / cushion.fx, (40 - cushion.cy) / cushion.fy, 1});
  mask.at(static_cast<int>(std::lround(where->x())), static_cast<int>(std::lround(where->y()))) = 0;
  EXPECT_EQ(undistorted(cushion, picture, mask).mask.at(30, 40), 0);
  EXPECT_TRUE(undistorted(kPinhole, photograph(kPinhole), {}).mask.empty()) << "all counts";
}

}  // namespace
}  // namespace sheen
