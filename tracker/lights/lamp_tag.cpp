// SPDX-License-Identifier: Apache-2.0
#include "tracker/lights/lamp_tag.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr double kHuber_px = 0.3;
constexpr double kWorstRms_px = 1.5;
constexpr double kKnown_m = 0.005;  // what is known to this is
constexpr double kCorner_px = 0.1;  // standard deviation of a corner
// The other pose is out where it fits worse by this much.
constexpr double kClearlyWorse = 3, kClearlyWorse_px = 0.3;

double rms_px(const Camera& camera, const std::vector<Correspondence>& points, const Rigid3& pose) {
  double sum = 0;
  for (const Correspondence& point : points) {
    const auto pixel = camera.project(pose * point.point_object);
    if (!pixel) return INFINITY;
    sum += (*pixel - point.pixel).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(points.size()));
}

/// Standard deviation, metres, in the worst direction, of a point of the tag's frame: noise of the corners through the
/// pose, which a step (w, t) on its left changes by w x p + t.
double uncertainty_m(const RefinedPose& pose, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = pose.camera_from_object * point;
  Eigen::Matrix<double, 3, 6> change;
  change << 0, p.z(), -p.y(), 1, 0, 0,  //
      -p.z(), 0, p.x(), 0, 1, 0,        //
      p.y(), -p.x(), 0, 0, 0, 1;
  const Eigen::LDLT<Matrix6> information(pose.information);
  if (information.rcond() < 1e-14 || !information.isPositive()) return INFINITY;
  const Eigen::Matrix3d covariance = kCorner_px * kCorner_px * change * information.solve(change.transpose());
  const double variance = covariance.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  return variance >= 0 ? std::sqrt(variance) : INFINITY;
}

}  // namespace

FrameLights::Answer LampTag::of(const Capture& frame) {
  const auto is_ours = [&](const TagObservation& tag) { return tag.id == *options_.tag; };
  const auto seen = std::count_if(frame.tags.begin(), frame.tags.end(), is_ours);
  if (seen != 1) return {std::nullopt, seen == 0 ? "lamp_tag_not_seen" : "lamp_tag_seen_twice"};
  const TagObservation& tag = *std::find_if(frame.tags.begin(), frame.tags.end(), is_ours);

  const double half = options_.tag_size_m / 2;
  std::vector<Correspondence> points;
  for (int corner = 0; corner < 4; ++corner)
    points.push_back({{corner == 0 || corner == 3 ? -half : half, corner < 2 ? half : -half, 0}, tag.corners[corner]});
  const std::vector<RefinedPose> poses = poses_of_points(frame.camera, points, kHuber_px);
  const auto rms_of = [&](const RefinedPose& pose) { return rms_px(frame.camera, points, pose.camera_from_object); };
  if (poses.empty() || !(rms_of(poses.front()) <= kWorstRms_px)) return {std::nullopt, "lamp_tag_broken"};

  const Rigid3 object_from_camera = frame.pose.camera_from_object.inverse();
  const auto lamp = [&](const RefinedPose& camera_from_tag) -> Eigen::Vector3d {
    return object_from_camera * (camera_from_tag.camera_from_object * options_.offset);
  };
  if (!(uncertainty_m(poses.front(), options_.offset) <= kKnown_m)) return {std::nullopt, "lamp_tag_uncertain"};
  const double best = rms_of(poses.front());
  for (const RefinedPose& other : poses) {
    const bool elsewhere = (lamp(other) - lamp(poses.front())).norm() > kKnown_m;
    if (elsewhere && rms_of(other) <= std::max(kClearlyWorse * best, kClearlyWorse_px))
      return {std::nullopt, "lamp_tag_uncertain"};
  }
  return {LightState{.kind = LightKind::kPoint, .position = lamp(poses.front())}, {}};
}

}  // namespace sheen
