// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/stage_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/tracker/synthetic_stage.h"

namespace sheen {
namespace {

using testing::exact_observations;
using testing::random_stage_pose;
using testing::render_stage;
using testing::stage_camera;

std::set<int> ids(const std::vector<TagObservation>& tags) {
  std::set<int> ids;
  for (const TagObservation& tag : tags) ids.insert(tag.id);
  return ids;
}

double centre_error_mm(const PoseEstimate& pose, const Rigid3& truth) {
  return 1e3 * (camera_centre(pose.camera_from_object) - camera_centre(truth)).norm();
}

struct Scene {
  Camera camera = stage_camera();
  StageLayout stage = make_stage({});
  Rigid3 truth;
  ImageU8 image;

  explicit Scene(unsigned seed) {
    std::mt19937 rng(seed);
    do truth = random_stage_pose(rng);
    while (exact_observations(camera, stage, truth).size() < 12);
    image = render_stage(camera, stage, truth);
    testing::add_pixel_noise(image, 2, rng);
  }
  StageSighting find(const StageLayout& layout) const { return StageFinder(camera, layout).find(image); }
};

/// Paints a triangle over half of a tag's code; its edges stay.
void cover(ImageU8& image, const TagObservation& tag, std::uint8_t grey) {
  const Eigen::Vector2d middle = (tag.corners[0] + tag.corners[2]) / 2;
  std::array<Eigen::Vector2d, 3> corners;
  for (int k = 0; k < 3; ++k) corners[k] = middle + 0.7 * (tag.corners[k] - middle);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      bool covered = true;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector2d edge = corners[(k + 1) % 3] - corners[k], to = Eigen::Vector2d(x, y) - corners[k];
        covered = covered && edge.x() * to.y() - edge.y() * to.x() >= 0;  // corners go clockwise, y points down
      }
      if (covered) image.at(x, y) = grey;
    }
}

TEST(StageFinder, FindsAllTagsOfTheFullSearchAndTheSamePose) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Scene scene(seed);
    const StageSighting coarse = scene.find(scene.stage);
    const StageSighting full = StageFinder(scene.camera, scene.stage, {.other_tags = true}).find(scene.image);
    ASSERT_EQ(coarse.pose.status, PoseStatus::kTracked);
    EXPECT_TRUE(std::ranges::includes(ids(coarse.tags), ids(full.tags))) << "seed " << seed;
    EXPECT_TRUE(
        std::ranges::includes(ids(coarse.tags), ids(exact_observations(scene.camera, scene.stage, scene.truth))))
        << "seed " << seed;
    EXPECT_LT(centre_error_mm(coarse.pose, scene.truth), 0.05);
  }
}

TEST(StageFinder, ReadsTheCodeBeforeItBelievesThatATagIsThere) {
  Scene scene(2);
  const auto truth = exact_observations(scene.camera, scene.stage, scene.truth);
  cover(scene.image, truth[3], 200);
  cover(scene.image, truth[7], 30);
  const StageSighting sighting = scene.find(scene.stage);
  std::set<int> rest = ids(truth);
  rest.erase(truth[3].id);
  rest.erase(truth[7].id);
  EXPECT_EQ(ids(sighting.tags), rest);
}

TEST(StageFinder, DoesNotTakeOneTagForAnother) {
  const Scene scene(3);
  StageLayout other = scene.stage;
  for (std::size_t k = 0; k < other.tags.size(); k += 2) other.tags[k].id += 200;  // what the sheet does not show
  const StageSighting sighting = scene.find(other);
  ASSERT_EQ(sighting.pose.status, PoseStatus::kTracked);
  for (const TagObservation& tag : sighting.tags) EXPECT_LT(tag.id, 200);
}

TEST(StageFinder, ATagElsewhereThanTheLayoutSaysDoesNotMoveThePose) {
  const Scene scene(4);
  StageLayout other = scene.stage;
  for (Eigen::Vector3d& corner : other.tags[5].corners_object) corner.y() += 0.003;
  const StageSighting sighting = scene.find(other);
  ASSERT_EQ(sighting.pose.status, PoseStatus::kTracked);
  EXPECT_LT(centre_error_mm(sighting.pose, scene.truth), 0.05);
  for (const TagObservation& tag : sighting.tags) EXPECT_EQ(tag.used, tag.id != other.tags[5].id) << tag.id;
}

TEST(StageFinder, SearchesFinerWhereACoarseImageShowsTooFewTags) {
  Scene scene(5);
  scene.truth.translation *= 3;  // tags of some 20 pixels: 5 in the coarsest image
  scene.image = render_stage(scene.camera, scene.stage, scene.truth);
  const auto truth = exact_observations(scene.camera, scene.stage, scene.truth);
  EXPECT_LT(TagDetector({.quad_decimate = 4}).detect(scene.image).size(), 4u);
  const StageSighting sighting = scene.find(scene.stage);
  ASSERT_EQ(sighting.pose.status, PoseStatus::kTracked);
  EXPECT_GE(sighting.tags.size(), truth.size() - 2);
}

TEST(StageFinder, SaysThatThereIsNoStage) {
  const Scene scene(6);
  StageFinder finder(scene.camera, scene.stage);
  const StageSighting none = finder.find(ImageU8(scene.image.width(), scene.image.height(), 1, 128));
  EXPECT_TRUE(none.tags.empty());
  EXPECT_EQ(none.pose.status, PoseStatus::kNoTags);
}

/// A rendered stage seen by another camera than that of the other tests, from nearer and through more noise.
TEST(StageFinder, StatesHowFarPosesAreOff) {
  const StageLayout stage = make_stage({.width_m = 0.25, .height_m = 0.2, .tag_m = 0.03});
  const Camera camera{.width = 640,
                      .height = 480,
                      .fx = 620,
                      .fy = 622,
                      .cx = 322.4,
                      .cy = 236.8,
                      .distortion = {0.05, -0.03, 0, 0.0006, 0}};
  StageFinder finder(camera, stage);
  std::mt19937 rng(12);
  std::uniform_real_distribution<double> place(-0.2, 0.2), height(0.3, 0.4), roll(0, 6);
  double sum = 0;
  constexpr int kImages = 40;
  for (int i = 0; i < kImages; ++i) {
    const double turn = roll(rng);
    const Rigid3 truth =
        look_at({place(rng), place(rng), height(rng)}, {0, 0, 0}, {std::cos(turn), std::sin(turn), 0.1});
    ImageU8 image = render_stage(camera, stage, truth, 8, 50, 180);
    testing::add_pixel_noise(image, 3, rng);
    const PoseEstimate pose = finder.find(image).pose;
    ASSERT_EQ(pose.status, PoseStatus::kTracked);
    sum += testing::squared_in_sigmas(pose, truth);
  }
  // Chi squared with 6 degrees of freedom: the mean of 40 has a standard deviation of 0.55.
  EXPECT_NEAR(sum / kImages, 6, 1.5);
}

}  // namespace
}  // namespace sheen
