// SPDX-License-Identifier: Apache-2.0
// Images of a stage through a lens whose focal length is not the calibrated one, by the exact projection of its corners
// and noise as edges have it.
#include "tracker/pose/focal_length.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/tracker/synthetic_stage.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

constexpr int kImages = 40;

class FocalLength : public ::testing::Test {
 protected:
  /// What is measured of an image that is taken with `scale` times the calibrated focal length.
  std::optional<FocalDeviation> measured(const Rigid3& pose, double scale, double spread_m = 0) {
    Camera lens = camera_;
    lens.fx *= scale;
    lens.fy *= scale;
    std::vector<TagObservation> tags = testing::exact_observations(lens, printed(spread_m), pose);
    testing::add_edge_noise(tags, 0.05, 0.02, rng_);
    const PoseEstimate solved = solve_pose(camera_, stage_, tags);
    return solved.usable() ? focal_deviation(camera_, stage_, tags, solved.camera_from_object) : std::nullopt;
  }
  /// With ink that has spread by so much.
  StageLayout printed(double spread_m) const {
    StageLayout stage = stage_;
    for (StageTag& tag : stage.tags) {
      const Eigen::Vector3d centre =
          (tag.corners_object[0] + tag.corners_object[1] + tag.corners_object[2] + tag.corners_object[3]) / 4;
      for (Eigen::Vector3d& corner : tag.corners_object)
        for (int axis = 0; axis < 2; ++axis) corner[axis] += std::copysign(spread_m, corner[axis] - centre[axis]);
    }
    return stage;
  }
  FocalWatch watched(const std::function<double(int)>& scale) {
    FocalWatch watch;
    for (int i = 0; i < kImages; ++i)
      if (const auto deviation = measured(testing::random_stage_pose(rng_), scale(i))) watch.add(*deviation);
    return watch;
  }

  std::mt19937 rng_{3};
  const StageLayout stage_ = make_stage({});
  const Camera camera_ = testing::stage_camera();
};

TEST_F(FocalLength, OfALensAsItWasCalibratedIsNoNews) {
  const FocalWatch watch = watched([](int) { return 1.0; });
  EXPECT_GE(watch.images(), 20u);
  EXPECT_LT(std::abs(watch.mean()), 4 * watch.sigma());
  EXPECT_LT(std::abs(watch.mean()), 0.001);
  EXPECT_EQ(watch.finding(), "");
}

TEST_F(FocalLength, ThatIsAnotherInAllImagesIsMeasuredAndNamed) {
  for (const double scale : {0.985, 1.01}) {
    const FocalWatch watch = watched([&](int) { return scale; });
    EXPECT_NEAR(watch.mean(), scale - 1, 4 * watch.sigma());
    EXPECT_NEAR(watch.mean(), scale - 1, 0.001);
    EXPECT_THAT(watch.finding(), HasSubstr(scale > 1 ? "1.0 % longer" : "1.5 % shorter"));
    EXPECT_THAT(watch.finding(), HasSubstr("lock focus"));
  }
}

TEST_F(FocalLength, ThatBreathesIsNamed) {
  const FocalWatch watch = watched([](int i) { return 1 + 0.012 * std::sin(0.7 * i); });
  EXPECT_NEAR(watch.spread(), 0.012 / std::sqrt(2), 0.003);
  EXPECT_THAT(watch.finding(), HasSubstr("from image to image"));
}

TEST_F(FocalLength, InkThatHasSpreadIsNoOtherLens) {
  FocalWatch watch;
  for (int i = 0; i < kImages; ++i)
    if (const auto deviation = measured(testing::random_stage_pose(rng_), 1, 0.0002)) watch.add(*deviation);
  EXPECT_GE(watch.images(), 20u);
  EXPECT_LT(std::abs(watch.mean()), 0.0015);
  EXPECT_EQ(watch.finding(), "");
}

TEST_F(FocalLength, AnImageFromStraightAboveHardlyTells) {
  const Rigid3 above = look_at({0, 0, 0.6}, {0, 0, 0}, {0, 1, 0});
  const Rigid3 tilted = look_at({0, 0.42, 0.42}, {0, 0, 0}, {0, 0, 1});
  const auto little = measured(above, 1), much = measured(tilted, 1);
  ASSERT_TRUE(little && much);
  EXPECT_GT(little->sigma, 5 * much->sigma);
  FocalWatch watch;
  for (int i = 0; i < 100; ++i) watch.add({0.5, 0.03});
  EXPECT_EQ(watch.finding(), "") << "what tells nothing proves nothing";
}

}  // namespace
}  // namespace sheen
