// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/pose_refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reconstructor/refinement/pose_judgement.h"
#include "tests/reconstructor/refinement/ball_photographs.h"
#include "tests/support/expect_error.h"
#include "tests/support/poses_off.h"

namespace sheen {
namespace {

double apart_px(const PosedCamera& right, const Rigid3& pose) {
  return apart_px(sphere_mesh(kRadius, 3), {right}, {pose});
}

double apart_px(const RefinementImages& right, const std::vector<Rigid3>& poses) {
  return apart_px(sphere_mesh(kRadius, 3), right.cameras, poses);
}

RefinementImages with_poses_off(const RefinementImages& images, double by_px) {
  return with_poses_off(images, {Eigen::Vector3d::Zero(), kRadius}, by_px, 3);
}

std::vector<Rigid3> poses_of(const std::vector<RefinedPose>& refined) {
  std::vector<Rigid3> poses;
  for (const RefinedPose& pose : refined) poses.push_back(pose.camera_from_object);
  return poses;
}

std::vector<std::size_t> numbers(std::size_t first, std::size_t end) {
  std::vector<std::size_t> numbers(end - first);
  std::iota(numbers.begin(), numbers.end(), first);
  return numbers;
}

class RefinePoses : public ::testing::Test {
 protected:
  const Photographs photographs_{ball(), 40, -0.98, false};
  const RefinementImages& right_ = photographs_.images();
  const Mesh mesh_ = sphere_mesh(kRadius, 4);
  const std::vector<std::size_t> all_ = numbers(0, 40);
};

TEST_F(RefinePoses, BringsPosesThatAreOffBack) {
  const RefinementImages off = with_poses_off(right_, 1.5);
  std::vector<Rigid3> given;
  for (const PosedCamera& view : off.cameras) given.push_back(view.camera_from_object);
  const double before = apart_px(right_, given);
  ASSERT_GT(before, 1);
  const std::vector<RefinedPose> refined = refine_poses(mesh_, off, all_, all_);
  EXPECT_LT(apart_px(right_, poses_of(refined)), 0.35 * before);
}

TEST_F(RefinePoses, StatesWhatIsLeft) {
  const std::vector<RefinedPose> refined = refine_poses(mesh_, right_, all_, all_);
  double squares = 0;
  for (std::size_t i = 0; i < refined.size(); ++i) {
    EXPECT_GT(refined[i].patches, 0u);
    EXPECT_NEAR(refined[i].moved_px, apart_px(right_.cameras[i], refined[i].camera_from_object), 0.1);
    squares += std::pow(refined[i].moved_px / refined[i].uncertainty_px, 2);
  }
  EXPECT_LT(squares / static_cast<double>(refined.size()), 2);
}

TEST_F(RefinePoses, AnImageThatDoesNotLeadFollowsTheOthersAndMovesNone) {
  RefinementImages off = right_;
  const auto turn = [](double radians) {
    return Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(radians, Eigen::Vector3d::UnitZ())), Eigen::Vector3d::Zero()};
  };
  off.cameras[0].camera_from_object = off.cameras[0].camera_from_object * turn(2 * kPixel / kRadius);
  const std::vector<RefinedPose> refined = refine_poses(mesh_, off, numbers(1, 40), {0});
  EXPECT_GT(apart_px(right_.cameras[0], off.cameras[0].camera_from_object), 1);
  EXPECT_LT(apart_px(right_.cameras[0], refined[0].camera_from_object), 0.2);
  for (std::size_t i = 1; i < refined.size(); ++i)
    EXPECT_EQ(refined[i].camera_from_object, right_.cameras[i].camera_from_object);
}

TEST_F(RefinePoses, AnImageThatShowsNothingStaysWhereItWasGiven) {
  RefinementImages images = right_;
  images.read = [&](std::size_t i) {
    Capture capture = right_.read(i);
    if (i == 5) capture.image = analytic::float_image(ImageF(kCamera.width, kCamera.height, 3));
    return capture;
  };
  const std::vector<RefinedPose> refined = refine_poses(mesh_, images, all_, all_);
  EXPECT_EQ(refined[5].camera_from_object, right_.cameras[5].camera_from_object);
  EXPECT_EQ(refined[5].patches, 0u);
  EXPECT_GT(refined[6].patches, 0u);
}

TEST_F(RefinePoses, RefusesWhatNoPoseCanBeFoundFrom) {
  expect_error<Error>([&] { refine_poses(mesh_, right_, {0}, all_); }, {"two images"});
}

TEST(JudgePoses, WhatGainsIsKeptAndWhatDoesNotIsNot) {
  const Photographs photographs(ball(), 60, -0.98, true);
  const Mesh mesh = sphere_mesh(kRadius, 5);
  const JudgedPoses right = refine_and_judge_poses(mesh, photographs.images(), {});
  EXPECT_EQ(right.judgement.images, 7u);
  EXPECT_TRUE(right.kept_given()) << right.judgement.gain_db;
  const RefinementImages off = with_poses_off(photographs.images(), 1.5);
  const std::vector<std::size_t> held_out{3, 11, 27};
  std::vector<std::size_t> steps;
  const JudgedPoses judged = refine_and_judge_poses(mesh, off, held_out, [&](std::size_t done, std::size_t of) {
    steps.push_back(done);
    EXPECT_EQ(of, (50u + 60u) + (50u + 7u) + 7u) << "images: 50 lead, 60 move, 7 judge";
  });
  EXPECT_TRUE(std::is_sorted(steps.begin(), steps.end()));
  EXPECT_EQ(steps.back(), 174u) << "judging is the last part of the work";
  EXPECT_EQ(judged.judgement.images, 7u) << "of the 57 that are not held out";
  EXPECT_FALSE(judged.kept_given());
  EXPECT_GT(judged.judgement.gain_db, 2);
  for (const std::size_t i : held_out) {
    const PosedCamera& truth = photographs.images().cameras[i];
    EXPECT_LT(apart_px(truth, judged.refined[i].camera_from_object),
              0.5 * apart_px(truth, off.cameras[i].camera_from_object));
  }
}

}  // namespace
}  // namespace sheen
