// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/camera_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/stage/stage_layout.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

class CameraPathOfAnyLength : public testing::TestWithParam<int> {};

TEST_P(CameraPathOfAnyLength, StaysWithinItsBoundsAndSeesTheStage) {
  const Camera camera = simulated_camera(1024, 768);
  const StageLayout stage = make_stage({});
  CameraPathOptions options;
  options.frames = GetParam();
  const auto path = camera_path(options, camera);
  ASSERT_EQ(int(path.size()), options.frames);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Rigid3& pose = path[i].camera_from_object;
    const Vector3d offset = camera_centre(pose) - options.target;
    EXPECT_GE(offset.norm(), options.nearest_m - 1e-9);
    EXPECT_LE(offset.norm(), options.farthest_m + 1e-9);
    const double elevation = std::asin(offset.z() / offset.norm()) * 180 / M_PI;
    EXPECT_GE(elevation, options.lowest_deg - 1e-9);
    EXPECT_LE(elevation, options.highest_deg + 1e-9);
    int tags = 0;
    for (const StageTag& tag : stage.tags)
      tags += std::ranges::all_of(tag.corners_object, [&](const Vector3d& corner) {
        const auto p = camera.project(pose * corner);
        return p && camera.contains(*p, 5);
      });
    EXPECT_GE(tags, 10) << "frame " << i;
    for (const Vector3d& corner : {Vector3d(0.1, 0, 0.09), Vector3d(-0.1, 0, 0.08), Vector3d(0, 0, 0.12)}) {
      const auto p = camera.project(pose * corner);
      ASSERT_TRUE(p);
      EXPECT_TRUE(camera.contains(*p, 20)) << "the object leaves frame " << i;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(CameraPath, CameraPathOfAnyLength, testing::Values(1, 12, 130, 300));

TEST(CameraPath, SpreadsItsViewsEvenly) {
  const CameraPathOptions options;
  const auto path = camera_path(options, simulated_camera(1024, 768));
  std::vector<Vector3d> directions;
  for (const auto& station : path)
    directions.push_back((camera_centre(station.camera_from_object) - options.target).normalized());
  // A band of the sphere shared out evenly: 2 pi (sin 75 - sin 18) / 130 sr a view.
  const double even = std::sqrt(2 * M_PI * (std::sin(75 * M_PI / 180) - std::sin(18 * M_PI / 180)) / options.frames);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    double nearest = 10;
    for (std::size_t j = 0; j < directions.size(); ++j)
      if (j != i) nearest = std::min(nearest, std::acos(std::clamp(directions[i].dot(directions[j]), -1.0, 1.0)));
    EXPECT_GT(nearest, 0.3 * even) << i;
    EXPECT_LT(nearest, 1.6 * even) << i;
  }
}

TEST(CameraPath, JerksBlurAFewFramesByAKnownLength) {
  const Camera camera = simulated_camera(1024, 768);
  const CameraPathOptions options;
  int moving = 0;
  for (const auto& station : camera_path(options, camera)) {
    if (!station.moves()) {
      EXPECT_EQ(station.streak_px(camera, options.target), 0);
      continue;
    }
    ++moving;
    EXPECT_NEAR(station.streak_px(camera, options.target), options.jerk_px, 0.15 * options.jerk_px);
    const Rigid3 back = station.at(0);
    EXPECT_NEAR((back.translation - station.camera_from_object.translation).norm(), 0, 1e-12);
    EXPECT_NEAR((camera_centre(station.at(0.5)) - camera_centre(back)).norm(), 0, 1e-9) << "it turns about itself";
  }
  EXPECT_EQ(moving, 4);
}

TEST(CameraPath, FollowsItsSeed) {
  const Camera camera = simulated_camera(640, 480);
  const auto first = camera_path({.frames = 20}, camera), again = camera_path({.frames = 20}, camera),
             other = camera_path({.frames = 20, .seed = 2}, camera);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(first[i].camera_from_object.translation, again[i].camera_from_object.translation);
    EXPECT_NE(first[i].camera_from_object.translation, other[i].camera_from_object.translation);
  }
}

TEST(CameraPath, RefusesNonsense) {
  const Camera camera = simulated_camera(640, 480);
  EXPECT_THROW(camera_path({.frames = 0}, camera), ConfigError);
  EXPECT_THROW(camera_path({.lowest_deg = 80}, camera), ConfigError);
  EXPECT_THROW(camera_path({.highest_deg = 90}, camera), ConfigError);
  EXPECT_THROW(camera_path({.nearest_m = std::nan("")}, camera), ConfigError);
}

}  // namespace
}  // namespace sheen
