// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/capture_pose.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/simulation/sensor.h"
#include "tests/tracker/synthetic_stage.h"
#include "tracker/pose/stage_finder.h"

namespace sheen {
namespace {

constexpr int kImages = 150, kImagesPerSetting = 60;
constexpr int kPosesOfNoisyCorners = 100'000;
constexpr double kPixelNoise = 2, kCornerNoise_px = 0.3, kMostTilt_deg = 60;
const Eigen::Vector3d kOnTheObject(0, 0, 0.06);  // metres

double degrees_apart(const Rigid3& a, const Rigid3& b) {
  return a.rotation.angularDistance(b.rotation) * 180 / M_PI;
}

void measure_images(GoalReport& report) {
  const StageLayout stage = make_stage({});
  const Camera camera = testing::stage_camera();
  StageFinder finder(camera, stage);
  std::mt19937 rng(1);
  std::vector<double> centre_mm, rotation_deg, object_px, in_sigmas, tags_seen;
  std::map<std::string, std::vector<double>> step_ms;
  while (centre_mm.size() < kImages) {
    const Rigid3 truth = testing::random_stage_pose(rng);
    if (testing::exact_observations(camera, stage, truth).size() < 6) continue;
    ImageU8 image = testing::render_stage(camera, stage, truth);
    testing::add_pixel_noise(image, kPixelNoise, rng);
    const StageSighting sighting = finder.find(image);
    const PoseEstimate& pose = sighting.pose;
    if (pose.status != PoseStatus::kTracked) continue;
    centre_mm.push_back(1e3 * (camera_centre(pose.camera_from_object) - camera_centre(truth)).norm());
    rotation_deg.push_back(degrees_apart(pose.camera_from_object, truth));
    object_px.push_back(
        (*camera.project(pose.camera_from_object * kOnTheObject) - *camera.project(truth * kOnTheObject)).norm());
    in_sigmas.push_back(testing::squared_in_sigmas(pose, truth));
    tags_seen.push_back(pose.tags_used);
    for (const auto& [step, ms] : sighting.stage_ms) step_ms[step].push_back(ms);
  }
  const std::string of = ", " + std::to_string(kImages) + " rendered images, p95";
  report.add(at_most(0.02, {}, "camera's centre" + of, quantile(centre_mm, 0.95), "mm",
                     {{"median", quantile(centre_mm, 0.5)}}));
  report.add(at_most(0.002, {}, "camera's rotation" + of, quantile(rotation_deg, 0.95), "degrees",
                     {{"median", quantile(rotation_deg, 0.5)}}));
  report.add(at_most(0.05, {}, "a point of the object" + of, quantile(object_px, 0.95), "px",
                     {{"median", quantile(object_px, 0.5)}}));
  double nees = 0;
  for (const double s : in_sigmas) nees += s / static_cast<double>(in_sigmas.size());
  report.add({"squared error in units of the stated covariance, mean (6 is right)", nees, "", {}});
  report.add({"tags of a pose, median", quantile(tags_seen, 0.5), "", {}});
  report.add({"tags found, median per image", quantile(step_ms["detect"], 0.5), "ms", {}});
  report.add({"edges fitted, median per image", quantile(step_ms["refine"], 0.5), "ms", {}});
  report.add({"pose, median per image", quantile(step_ms["solve"], 0.5), "ms", {}});
}

/// How a stage is seen in a setting other than that of `measure_images`.
struct Setting {
  const char* what;
  double distance = 1;  ///< times 0.55 to 0.75 m
  double noise = kPixelNoise;
  double spot_px = 0;  ///< standard deviation of the lens's spot
};

ImageU8 seen_through_lens(const ImageU8& sharp, double spot_px) {
  ImageF image(sharp.width(), sharp.height(), 1);
  std::copy_n(sharp.data(), sharp.size(), image.data());
  image = through_lens(image, spot_px);
  ImageU8 seen(sharp.width(), sharp.height(), 1);
  std::transform(image.data(), image.data() + image.size(), seen.data(),
                 [](float level) { return static_cast<std::uint8_t>(std::lround(level)); });
  return seen;
}

/// Whether poses are off as far as they say, in other settings, too.
void measure_stated_errors(GoalReport& report) {
  const StageLayout stage = make_stage({});
  const Camera camera = testing::stage_camera();
  StageFinder finder(camera, stage);
  for (const Setting& setting :
       {Setting{.what = "nearer", .distance = 0.6}, Setting{.what = "twice as far", .distance = 2},
        Setting{.what = "noise of 6 grey levels", .noise = 6},
        Setting{.what = "a lens's spot of 0.7 px", .spot_px = 0.7},
        Setting{.what = "a lens's spot of 1.5 px", .spot_px = 1.5}}) {
    std::mt19937 rng(3);
    double sum = 0;
    for (int solved = 0; solved < kImagesPerSetting;) {
      Rigid3 truth = testing::random_stage_pose(rng);
      truth.translation *= setting.distance;
      if (testing::exact_observations(camera, stage, truth).size() < 6) continue;
      ImageU8 image = testing::render_stage(camera, stage, truth);
      if (setting.spot_px > 0) image = seen_through_lens(image, setting.spot_px);
      testing::add_pixel_noise(image, setting.noise, rng);
      const PoseEstimate pose = finder.find(image).pose;
      if (pose.status != PoseStatus::kTracked) continue;
      sum += testing::squared_in_sigmas(pose, truth);
      ++solved;
    }
    report.add({std::string("squared error in units of the stated covariance, ") + setting.what + ", mean",
                sum / kImagesPerSetting,
                "",
                {}});
  }
}

void measure_flips(GoalReport& report) {
  const StageLayout stage = make_stage({});
  const Camera camera = testing::stage_camera(true);
  std::mt19937 rng(2);
  int solved = 0, flipped = 0;
  while (solved < kPosesOfNoisyCorners) {
    const Rigid3 truth = testing::random_stage_pose(rng, kMostTilt_deg);
    std::vector<TagObservation> tags = testing::exact_observations(camera, stage, truth);
    if (tags.size() < 6) continue;
    testing::add_corner_noise(tags, kCornerNoise_px, rng);
    const PoseEstimate pose = solve_pose(camera, stage, tags);
    ++solved;
    flipped += pose.status != PoseStatus::kTracked || degrees_apart(pose.camera_from_object, truth) > 1;
  }
  report.add(at_most(0, {}, "poses that are flipped or missing, of 10^5 with corners off by 0.3 px", flipped, ""));
}

}  // namespace

void measure_poses(GoalReport& report) {
  measure_images(report);
  measure_stated_errors(report);
  measure_flips(report);
}

}  // namespace sheen
