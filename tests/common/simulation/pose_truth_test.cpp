// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/pose_truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/errors.h"
#include "tests/support/temp_folder.h"

namespace sheen {
namespace {

RigRecording two_frames() {
  RigRecording recording;
  recording.frames.resize(2);
  recording.frames[0].camera_from_object = look_at({0.5, 0, 0.3}, {0, 0, 0}, {0, 0, 1});
  recording.frames[1].camera_from_object = look_at({0, 0.5, 0.3}, {0, 0, 0}, {0, 0, 1});
  return recording;
}

Capture capture_of(std::uint64_t id, const Rigid3& pose) {
  Capture capture;
  capture.camera_frame_id = id;
  capture.pose.camera_from_object = pose;
  return capture;
}

TEST(PoseTruth, ErrorsAreThoseThatWerePutIn) {
  const RigRecording recording = two_frames();
  // Turned by 0.01 degrees about the camera's own centre, then moved by 0.2 mm.
  const Rigid3 truth = recording.frames[1].camera_from_object;
  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(0.01 * M_PI / 180, Eigen::Vector3d::UnitY())), {2e-4, 0, 0}};
  PoseErrors errors;
  add_pose_error(capture_of(7, turn * truth), recording, {{7, 1}}, errors);
  ASSERT_EQ(errors.centre_mm.size(), 1u);
  EXPECT_NEAR(errors.centre_mm[0], 0.2, 1e-6);
  EXPECT_NEAR(errors.rotation_deg[0], 0.01, 1e-6);
}

TEST(PoseTruth, AnIdThatCameTwiceMeansTheNearestFrameAndAnUnknownOneIsCounted) {
  const RigRecording recording = two_frames();
  PoseErrors errors;
  add_pose_error(capture_of(3, recording.frames[1].camera_from_object), recording, {{3, 0}, {3, 1}}, errors);
  EXPECT_NEAR(errors.centre_mm.at(0), 0, 1e-9);
  add_pose_error(capture_of(4, recording.frames[1].camera_from_object), recording, {{3, 0}, {3, 1}}, errors);
  EXPECT_EQ(errors.unmatched, 1u);
  EXPECT_EQ(errors.centre_mm.size(), 1u);
}

TEST(PoseTruth, TheLogIsReadLineByLine) {
  const TempFolder folder;
  folder.write("sent.csv", "65401,0\n65402,1\n");
  const SentFrames sent = read_sent_frames(folder.path() / "sent.csv");
  ASSERT_EQ(sent.size(), 2u);
  EXPECT_EQ(sent.find(65402)->second, 1u);
  folder.write("sent.csv", "65401,0\n65402;1\n");
  try {
    read_sent_frames(folder.path() / "sent.csv");
    FAIL() << "a broken line was read";
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("line 2"), std::string::npos) << error.what();
  }
  EXPECT_THROW(read_sent_frames(folder.path() / "none.csv"), FileError);
}

}  // namespace
}  // namespace sheen
