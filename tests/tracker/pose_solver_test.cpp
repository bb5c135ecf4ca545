// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/pose_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/tracker/synthetic_stage.h"

namespace sheen {
namespace {

using testing::add_corner_noise;
using testing::exact_observations;
using testing::random_stage_pose;
using testing::stage_camera;

double rotation_error(const Rigid3& a, const Rigid3& b) {
  return a.rotation.angularDistance(b.rotation);
}
double centre_error(const Rigid3& a, const Rigid3& b) {
  return (camera_centre(a) - camera_centre(b)).norm();
}

TEST(PoseSolver, RecoversExactPoses) {
  const StageLayout stage = make_stage({});
  std::mt19937 rng(1);
  for (int i = 0; i < 200; ++i) {
    const Camera camera = stage_camera(i % 2 == 0);
    const Rigid3 truth = random_stage_pose(rng);
    auto tags = exact_observations(camera, stage, truth);
    ASSERT_GE(tags.size(), 6u);
    const PoseEstimate pose = solve_pose(camera, stage, tags);
    ASSERT_EQ(pose.status, PoseStatus::kTracked);
    EXPECT_LT(centre_error(pose.camera_from_object, truth), 1e-9);
    EXPECT_LT(rotation_error(pose.camera_from_object, truth), 1e-8);
    EXPECT_EQ(pose.tags_used, static_cast<int>(tags.size()));
    EXPECT_LT(pose.reprojection_rms_px, 1e-6);
  }
}

TEST(PoseSolver, NeverFlipsThePlane) {
  const StageLayout stage = make_stage({});
  const Camera camera = stage_camera(true);
  std::mt19937 rng(2);
  int solved = 0;
  for (int i = 0; i < 3000; ++i) {
    const Rigid3 truth = random_stage_pose(rng, 60);
    auto tags = exact_observations(camera, stage, truth);
    add_corner_noise(tags, 0.3, rng);
    if (tags.size() < 6) continue;
    const PoseEstimate pose = solve_pose(camera, stage, tags);
    ASSERT_EQ(pose.status, PoseStatus::kTracked);
    ASSERT_LT(rotation_error(pose.camera_from_object, truth), 1 * M_PI / 180) << "pose " << i;
    ++solved;
  }
  EXPECT_GT(solved, 2900);
}

/// Two neighbouring tags far away are the case in which the mirrored plane fits nearly as well.
TEST(PoseSolver, FewTagsChooseTheBetterOfBothPlanes) {
  const StageLayout stage = make_stage({});
  const Camera camera = stage_camera(true);
  std::mt19937 rng(3);
  for (int i = 0; i < 500; ++i) {
    const Rigid3 truth = random_stage_pose(rng, 60);
    auto tags = exact_observations(camera, stage, truth);
    tags.resize(2);
    add_corner_noise(tags, 0.02, rng);
    const PoseEstimate pose = solve_pose(camera, stage, tags);
    ASSERT_EQ(pose.status, PoseStatus::kTracked);
    EXPECT_LT(rotation_error(pose.camera_from_object, truth), 3 * M_PI / 180) << "pose " << i;
  }
}

/// Monte Carlo over poses and errors of corners, which err independently of each other or as the lines of edges do.
TEST(PoseSolver, CovarianceAgreesWithTheErrors) {
  struct Errors {
    const char* what;
    double corner_px, point_px, edge_px;  // standard deviations, see add_corner_noise and add_edge_noise
    std::size_t tags;
  };
  const StageLayout stage = make_stage({});
  const Camera camera = stage_camera();
  constexpr int kTrials = 500;
  for (const Errors& errors :
       {Errors{"sharp", 0, 0.025, 0, 24}, Errors{"noisy", 0, 0.1, 0, 24}, Errors{"six tags", 0, 0.025, 0, 6},
        Errors{"edges moved by blur", 0, 0.03, 0.02, 24}, Errors{"six tags, edges moved", 0, 0.03, 0.02, 6},
        Errors{"independent corners", 0.05, 0, 0, 24}}) {
    SCOPED_TRACE(errors.what);
    std::mt19937 rng(4);
    double sum = 0;
    for (int i = 0; i < kTrials; ++i) {
      const Rigid3 truth = random_stage_pose(rng);
      auto tags = exact_observations(camera, stage, truth);
      std::ranges::shuffle(tags, rng);
      tags.resize(std::min(tags.size(), errors.tags));
      add_corner_noise(tags, errors.corner_px, rng);
      testing::add_edge_noise(tags, errors.point_px, errors.edge_px, rng);
      const PoseEstimate pose = solve_pose(camera, stage, tags, {.drop_mads = 100});
      ASSERT_EQ(pose.status, PoseStatus::kTracked);
      sum += testing::squared_in_sigmas(pose, truth);
    }
    // Chi squared with 6 degrees of freedom: the mean over the trials has a standard deviation of sqrt(12 / trials),
    // 0.15. Of six tags the error is one of Student's t, whose squares vary more.
    EXPECT_NEAR(sum / kTrials, 6, errors.tags < 10 ? 0.8 : 0.45);
  }
}

TEST(PoseSolver, DropsATagThatStandsElsewhere) {
  const StageLayout stage = make_stage({});
  const Camera camera = stage_camera();
  std::mt19937 rng(5);
  for (int i = 0; i < 100; ++i) {
    const Rigid3 truth = random_stage_pose(rng);
    auto tags = exact_observations(camera, stage, truth);
    add_corner_noise(tags, 0.02, rng);
    const std::size_t wrong = i % tags.size();
    const double shift = i % 3 == 0 ? 2 : i % 3 == 1 ? 40 : 600;
    for (auto& corner : tags[wrong].corners) corner.x() += shift;
    const PoseEstimate pose = solve_pose(camera, stage, tags);
    ASSERT_EQ(pose.status, PoseStatus::kTracked) << "shift " << shift;
    EXPECT_FALSE(tags[wrong].used);
    EXPECT_GT(tags[wrong].residual_px, 0.5 * shift);
    EXPECT_LT(centre_error(pose.camera_from_object, truth), 2e-4);
  }
}

TEST(PoseSolver, IgnoresStrangersAndTagsSeenTwice) {
  const StageLayout stage = make_stage({});
  const Camera camera = stage_camera();
  std::mt19937 rng(6);
  const Rigid3 truth = random_stage_pose(rng, 20);
  auto tags = exact_observations(camera, stage, truth);
  tags.push_back({.id = 500, .corners = tags[0].corners});
  tags.push_back({.id = tags[3].id, .corners = tags[5].corners});
  const PoseEstimate pose = solve_pose(camera, stage, tags);
  ASSERT_EQ(pose.status, PoseStatus::kTracked);
  EXPECT_LT(centre_error(pose.camera_from_object, truth), 1e-9);
  EXPECT_FALSE(tags[3].used);
  EXPECT_FALSE(tags[tags.size() - 1].used);
  EXPECT_FALSE(tags[tags.size() - 2].used);
  EXPECT_EQ(pose.tags_used, static_cast<int>(tags.size()) - 3);
}

TEST(PoseSolver, SaysWhyThereIsNoPose) {
  const StageLayout stage = make_stage({});
  const Camera camera = stage_camera();
  std::vector<TagObservation> none;
  EXPECT_EQ(solve_pose(camera, stage, none).status, PoseStatus::kNoTags);
  std::mt19937 rng(7);
  auto tags = exact_observations(camera, stage, random_stage_pose(rng, 20));
  auto one = tags;
  one.resize(1);
  EXPECT_EQ(solve_pose(camera, stage, one).status, PoseStatus::kTooFewTags);
  std::uniform_real_distribution<double> anywhere(0, 760);
  for (TagObservation& tag : tags)
    for (Eigen::Vector2d& corner : tag.corners) corner = {anywhere(rng), anywhere(rng)};
  EXPECT_EQ(solve_pose(camera, stage, tags).status, PoseStatus::kInconsistent);
  for (TagObservation& tag : tags) tag.corners.fill({100, 100});
  EXPECT_EQ(solve_pose(camera, stage, tags).status, PoseStatus::kInconsistent);
}

}  // namespace
}  // namespace sheen
