// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/frame_lights.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "common/base/errors.h"
#include "tests/support/temp_folder.h"
#include "tests/tracker/synthetic_stage.h"

namespace sheen {
namespace {

using ::testing::HasSubstr;

constexpr int kLampTag = 300;
constexpr double kTagSize_m = 0.04;

Capture frame(std::uint64_t id) {
  Capture capture;
  capture.camera_frame_id = id;
  return capture;
}

class LightTableFile : public ::testing::Test {
 protected:
  LightTableFile() { options_.table = temp_.write("lamps.lp", "3\na 0.5 0 0.9\nb 0 0.5 0.8\nc -0.5 0 0.75\n"); }
  void expect_light(FrameLights& lights, std::uint64_t id, const Eigen::Vector3d& place) const {
    const FrameLights::Answer answer = lights.of(frame(id));
    ASSERT_TRUE(answer.light) << answer.refusal;
    EXPECT_EQ(answer.light->kind, LightKind::kPoint);
    EXPECT_EQ(answer.light->position, place);
  }
  static void expect_refusal(FrameLights& lights, std::uint64_t id, const std::string& reason) {
    const FrameLights::Answer answer = lights.of(frame(id));
    EXPECT_FALSE(answer.light);
    EXPECT_EQ(answer.refusal, reason);
  }

  const TempFolder temp_;
  LightOptions options_;
};

TEST_F(LightTableFile, CountsFramesFromTheFirst) {
  options_.first_frame = 5;
  const auto lights = make_frame_lights(options_);
  expect_light(*lights, 5, {0.5, 0, 0.9});
  expect_light(*lights, 7, {-0.5, 0, 0.75});
  expect_refusal(*lights, 8, "beyond_light_table");
  expect_refusal(*lights, 4, "beyond_light_table");
}

TEST_F(LightTableFile, FollowsTheIndexThatAControllerWrites) {
  options_.index = temp_.path() / "index.csv";
  const auto lights = make_frame_lights(options_);  // before the controller has begun
  expect_refusal(*lights, 1, "no_light_index");
  std::ofstream index(options_.index);
  index << "1,2\n2,0\n7,3\n" << std::flush;
  expect_light(*lights, 1, {-0.5, 0, 0.75});
  expect_light(*lights, 2, {0.5, 0, 0.9});
  expect_refusal(*lights, 7, "beyond_light_table");
  expect_refusal(*lights, 3, "no_light_index");
  index << "3,1" << std::flush;  // half a line: it may be 3,12
  expect_refusal(*lights, 3, "no_light_index");
  std::jthread controller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    index << "\n" << std::flush;
  });
  expect_light(*lights, 3, {0, 0.5, 0.8});
}

TEST_F(LightTableFile, NamesWhatIsWrong) {
  options_.index = temp_.write("index.csv", "1,2\n2;0\n");
  try {
    make_frame_lights(options_);
    FAIL() << "a broken line was taken";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("index.csv"));
    EXPECT_THAT(error.what(), HasSubstr("line 2: must be FRAME,ENTRY"));
  }
  options_.table = temp_.path() / "none.lp";
  EXPECT_THROW(make_frame_lights(options_), FileError);
}

TEST(LightOptions, TakeOneSourceOfLight) {
  EXPECT_THAT(validation_error(LightOptions{}), HasSubstr("table or tag"));
  EXPECT_THAT(validation_error(LightOptions{.table = "a.lp"}), HasSubstr("table needs index"));
  EXPECT_THAT(validation_error(LightOptions{.table = "a.lp", .index = "b", .first_frame = 1}),
              HasSubstr("table needs index"));
  EXPECT_THAT(validation_error(LightOptions{.table = "a.lp", .tag = 3}), HasSubstr("table or tag"));
  EXPECT_THAT(validation_error(LightOptions{.tag = 3}), HasSubstr("tag_size_m must"));
  EXPECT_THAT(validation_error(LightOptions{.first_frame = 1, .tag = 3, .tag_size_m = 0.1}),
              HasSubstr("belong to a table"));
  EXPECT_EQ(validation_error(LightOptions{.tag = 3, .tag_size_m = 0.1}), "");
  EXPECT_EQ(validation_error(LightOptions{.table = "a.lp", .first_frame = 0}), "");
}

/// A lamp on an arm above the stage, its tag turned towards the camera by some angle off its line of sight.
class LampOnTheStage : public ::testing::Test {
 protected:
  LampOnTheStage() {
    view_.camera = testing::stage_camera();
    std::mt19937 rng(3);
    view_.pose = {.status = PoseStatus::kTracked, .camera_from_object = testing::random_stage_pose(rng, 30)};
    options_ = {.tag = kLampTag, .tag_size_m = kTagSize_m, .offset = {0.01, -0.03, 0.05}};
  }
  /// The tag at `centre` of the stage's frame, tilted so about its own x.
  Rigid3 object_from_tag(const Eigen::Vector3d& centre, double tilt_deg) const {
    const Rigid3 object_from_camera = view_.pose.camera_from_object.inverse();
    // x right, y up, z towards the camera: its y and z against the camera's.
    const Eigen::Quaterniond facing = object_from_camera.rotation * Eigen::Quaterniond(0, 1, 0, 0);
    const Eigen::AngleAxisd tilt(tilt_deg * M_PI / 180, Eigen::Vector3d::UnitX());
    return {facing * Eigen::Quaterniond(tilt), centre};
  }
  void show(const Rigid3& object_from_tag) {
    TagObservation tag{.id = kLampTag};
    const double h = kTagSize_m / 2;
    const Eigen::Vector3d corners[] = {{-h, h, 0}, {h, h, 0}, {h, -h, 0}, {-h, -h, 0}};
    for (int k = 0; k < 4; ++k) {
      const auto pixel = view_.camera.project(view_.pose.camera_from_object * (object_from_tag * corners[k]));
      ASSERT_TRUE(pixel);
      tag.corners[k] = *pixel;
    }
    view_.tags.push_back(tag);
  }

  Capture view_;
  LightOptions options_;
};

TEST_F(LampOnTheStage, IsWhereItsTagSays) {
  const Rigid3 truth = object_from_tag({0.05, -0.04, 0.1}, 35);
  show(truth);
  const FrameLights::Answer answer = make_frame_lights(options_)->of(view_);
  ASSERT_TRUE(answer.light) << answer.refusal;
  EXPECT_EQ(answer.light->kind, LightKind::kPoint);
  EXPECT_LT((answer.light->position - truth * options_.offset).norm(), 1e-6);
}

TEST_F(LampOnTheStage, NoisyCornersMoveItByMillimetres) {
  const Rigid3 truth = object_from_tag({0.05, -0.04, 0.1}, 35);
  std::mt19937 rng(5);
  double worst = 0;
  for (int i = 0; i < 50; ++i) {
    view_.tags.clear();
    show(truth);
    testing::add_corner_noise(view_.tags, 0.05, rng);
    const FrameLights::Answer answer = make_frame_lights(options_)->of(view_);
    ASSERT_TRUE(answer.light) << answer.refusal;
    worst = std::max(worst, (answer.light->position - truth * options_.offset).norm());
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_GT(worst, 1e-5);
}

TEST_F(LampOnTheStage, NothingIsGuessed) {
  const auto lights = make_frame_lights(options_);
  EXPECT_EQ(lights->of(view_).refusal, "lamp_tag_not_seen");
  show(object_from_tag({0.05, -0.04, 0.1}, 35));
  show(object_from_tag({-0.05, 0.04, 0.1}, 35));
  EXPECT_EQ(lights->of(view_).refusal, "lamp_tag_seen_twice");

  // Nearly head-on its tilt hardly shows: at the end of an arm the lamp may be anywhere.
  view_.tags.clear();
  show(object_from_tag({0, 0, 0.05}, 0));
  std::mt19937 rng(7);
  testing::add_corner_noise(view_.tags, 0.1, rng);
  LightOptions long_arm = options_;
  long_arm.offset = {0, 0, 0.4};
  EXPECT_EQ(make_frame_lights(long_arm)->of(view_).refusal, "lamp_tag_uncertain");
  LightOptions in_the_middle = options_;
  in_the_middle.offset = {0, 0, 0};
  EXPECT_TRUE(make_frame_lights(in_the_middle)->of(view_).light) << "the tag's centre does not depend on its tilt";

  for (Eigen::Vector2d& corner : view_.tags[0].corners) corner = {100, 100};
  EXPECT_EQ(lights->of(view_).refusal, "lamp_tag_broken") << "a tag that has no size";
  view_.tags[0].corners = {{{100, 100}, {200, 100}, {90, 300}, {400, 120}}};
  EXPECT_EQ(lights->of(view_).refusal, "lamp_tag_broken");
}

}  // namespace
}  // namespace sheen
