// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "common/image/image_io.h"
#include "tests/support/shared_data.h"
#include "tests/tracker/synthetic_stage.h"
#include "tracker/fiducials/corner_refiner.h"
#include "tracker/fiducials/tag_detector.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

using testing::exact_observations;
using testing::random_stage_pose;
using testing::render_stage;
using testing::stage_camera;

const TagObservation* find(const std::vector<TagObservation>& tags, int id) {
  const auto it = std::ranges::find(tags, id, &TagObservation::id);
  return it == tags.end() ? nullptr : &*it;
}

double percentile(std::vector<double> values, double p) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(p * (values.size() - 1))];
}

std::vector<double> corner_errors(const std::vector<TagObservation>& found, const std::vector<TagObservation>& truth) {
  std::vector<double> errors;
  for (const TagObservation& t : truth)
    if (const TagObservation* f = find(found, t.id))
      for (int c = 0; c < 4; ++c) errors.push_back((f->corners[c] - t.corners[c]).norm());
  return errors;
}

/// Takes the colour of a Bayer filter's sites out of a grey picture: the sites answer with these gains.
RawImage as_bayer(const ImageU8& grey, double red, double green, double blue) {
  RawImage image{.format = PixelFormat::kBayerRG8, .width = grey.width(), .height = grey.height()};
  image.stride = image.width;
  image.bytes.resize(grey.size());
  for (int y = 0; y < grey.height(); ++y)
    for (int x = 0; x < grey.width(); ++x) {
      const double gain = y % 2 == 0 ? (x % 2 == 0 ? red : green) : (x % 2 == 0 ? green : blue);
      image.bytes[y * image.stride + x] = static_cast<std::uint8_t>(std::lround(gain * grey.at(x, y)));
    }
  return image;
}

struct Rendered {
  Camera camera;
  StageLayout stage = make_stage({});
  Rigid3 truth;
  ImageU8 image;
  std::vector<TagObservation> tags;
};

Rendered rendered_stage(unsigned seed, bool pinhole) {
  Rendered r{.camera = stage_camera(pinhole)};
  std::mt19937 rng(seed);
  r.truth = random_stage_pose(rng, 45);
  r.image = render_stage(r.camera, r.stage, r.truth);
  testing::add_pixel_noise(r.image, 2, rng);
  r.tags = exact_observations(r.camera, r.stage, r.truth);
  return r;
}

TEST(TagDetector, FindsTagsInTheContractsCornerOrder) {
  const Rendered r = rendered_stage(1, true);
  const auto found = TagDetector().detect(r.image);
  ASSERT_GE(r.tags.size(), 20u);
  EXPECT_GE(found.size(), r.tags.size() - 1);
  const auto errors = corner_errors(found, r.tags);
  ASSERT_FALSE(errors.empty());
  EXPECT_LT(percentile(errors, 0.95), 0.5);  // a wrong order would be tens of pixels off, no offset 0.7 px
}

TEST(CornerRefiner, HitsRenderedCornersThroughAPinholeAndALens) {
  for (const bool pinhole : {true, false})
    for (unsigned seed = 1; seed <= 2; ++seed) {
      const Rendered r = rendered_stage(seed, pinhole);
      auto found = TagDetector().detect(r.image);
      const std::size_t detected = found.size();
      refine_corners(r.image, r.camera, found);
      EXPECT_GE(found.size(), detected - 1);
      const auto errors = corner_errors(found, r.tags);
      ASSERT_GT(errors.size(), 60u);
      EXPECT_LT(percentile(errors, 0.5), 0.014);
      EXPECT_LT(percentile(errors, 0.95), 0.05);
    }
}

TEST(CornerRefiner, PoseFromRenderedStageIsExactToHundredthsOfAMillimetre) {
  for (unsigned seed = 3; seed <= 5; ++seed) {
    const Rendered r = rendered_stage(seed, false);
    const ImageU8 grey = detection_image(as_bayer(r.image, 0.5, 1, 0.7));
    auto found = TagDetector().detect(grey);
    refine_corners(grey, r.camera, found);
    const PoseEstimate pose = solve_pose(r.camera, r.stage, found);
    ASSERT_EQ(pose.status, PoseStatus::kTracked);
    EXPECT_LT((camera_centre(pose.camera_from_object) - camera_centre(r.truth)).norm(), 5e-5);
    EXPECT_LT(pose.camera_from_object.rotation.angularDistance(r.truth.rotation), 5e-5);
  }
}

TEST(CornerRefiner, DropsTagsWithoutMeasurableEdges) {
  const Rendered r = rendered_stage(1, true);
  auto tags = r.tags;
  const ImageU8 flat(r.image.width(), r.image.height(), 1, 128);
  refine_corners(flat, r.camera, tags);
  EXPECT_TRUE(tags.empty());

  std::vector<TagObservation> hostile(3);
  hostile[0].corners.fill({100, 100});                                        // no area
  hostile[1].corners = {{{-50, -50}, {2000, -50}, {2000, 900}, {-50, 900}}};  // outside
  hostile[2].corners = {{{10, 10}, {14, 10}, {14, 14}, {10, 14}}};            // too small
  refine_corners(r.image, r.camera, hostile);
  EXPECT_TRUE(hostile.empty());
}

TEST(MeasuredStreak, ReadsAJerkFromTheWidthOfTheEdges) {
  const Rendered r = rendered_stage(2, false);
  EXPECT_EQ(measured_streak_px(r.image, r.camera, r.tags), 0);
  ImageU8 streaked = r.image;  // a box of 7 px along x
  for (int y = 0; y < streaked.height(); ++y)
    for (int x = 3; x < streaked.width() - 3; ++x) {
      int sum = 0;
      for (int k = -3; k <= 3; ++k) sum += r.image.at(x + k, y);
      streaked.at(x, y) = static_cast<std::uint8_t>(sum / 7);
    }
  EXPECT_GT(measured_streak_px(streaked, r.camera, r.tags), 3);
  EXPECT_EQ(measured_streak_px(streaked, r.camera, {}), 0);
}

TEST(DetectionImage, BalancesTheSitesOfABayerMosaic) {
  const Rendered r = rendered_stage(1, true);
  const ImageU8 balanced = detection_image(as_bayer(r.image, 0.5, 1, 0.7));
  double sum = 0, square = 0;
  for (std::size_t i = 0; i < balanced.size(); ++i) {
    const double d = double(balanced.data()[i]) - r.image.data()[i];
    sum += d;
    square += d * d;
  }
  EXPECT_NEAR(sum / balanced.size(), 0, 2);
  EXPECT_LT(std::sqrt(square / balanced.size()), 3);
}

/// Photographs with the ids and corners that their makers published beside them.
TEST(TagDetector, FindsThePublishedTagsInPhotographs) {
  const std::filesystem::path folder = shared_data("tags_apriltag");
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no photographs of tags in " << folder;
  int photographs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".jpg") continue;
    ++photographs;
    const auto found =
        TagDetector({.quad_decimate = 1, .max_hamming = 2}).detect(detection_image(read_image(entry.path())));
    std::ifstream published(std::filesystem::path(entry.path()).replace_extension(".txt"));
    std::string line;
    int expected = 0, matched = 0;
    while (std::getline(published, line)) {
      std::ranges::replace_if(
          line, [](char c) { return c == ',' || c == '(' || c == ')'; }, ' ');
      std::istringstream fields(line);
      int id = -1;
      if (!(fields >> id)) continue;
      ++expected;
      Eigen::Vector2d centre(0, 0);
      for (int c = 0; c < 4; ++c) {
        Eigen::Vector2d p;
        ASSERT_TRUE(fields >> p.x() >> p.y()) << line;
        centre += p / 4;
      }
      for (const TagObservation& tag : found) {
        Eigen::Vector2d own(0, 0);
        for (const auto& p : tag.corners) own += p / 4;
        if (tag.id == id && (own - centre).norm() < 2) ++matched;
      }
    }
    EXPECT_GT(expected, 0);
    EXPECT_GE(matched, expected - 1) << entry.path();
  }
  EXPECT_EQ(photographs, 3);
}

}  // namespace
}  // namespace sheen
