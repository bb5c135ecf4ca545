// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/capture_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "common/base/order_statistics.h"
#include "tests/tracker/synthetic_stage.h"
#include "tracker/pose/stage_finder.h"

namespace sheen {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kImages = 150;
constexpr int kPosesOfNoisyCorners = 100'000;
constexpr double kPixelNoise = 2, kCornerNoise_px = 0.3, kMostTilt_deg = 60;
const Eigen::Vector3d kOnTheObject(0, 0, 0.06);  // metres

double degrees_apart(const Rigid3& a, const Rigid3& b) {
  return a.rotation.angularDistance(b.rotation) * 180 / M_PI;
}

/// The step from the estimate to the truth, in units of the covariance: chi squared with 6 degrees of freedom.
double squared_in_sigmas(const PoseEstimate& pose, const Rigid3& truth) {
  const Eigen::Quaterniond turn = truth.rotation * pose.camera_from_object.rotation.conjugate();
  const Eigen::AngleAxisd angle(turn);
  Vector6 step;
  step << angle.axis() * angle.angle(), truth.translation - turn * pose.camera_from_object.translation;
  return step.dot(pose.covariance.ldlt().solve(step));
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
    in_sigmas.push_back(squared_in_sigmas(pose, truth));
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
  measure_flips(report);
}

}  // namespace sheen
