// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/pose_solver.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "common/base/order_statistics.h"
#include "tracker/pose/edge_weights.h"
#include "tracker/pose/reprojection.h"

namespace sheen {
namespace {

constexpr double kMadToSigma = 1.4826;
constexpr int kMaxDropRounds = 3;

std::vector<Correspondence> stage_correspondences(const StageLayout& stage, const std::vector<TagObservation>& tags) {
  std::map<int, int> sightings;
  for (const TagObservation& tag : tags) ++sightings[tag.id];
  std::vector<Correspondence> points;
  for (int i = 0; i < static_cast<int>(tags.size()); ++i) {
    const StageTag* known = stage.find(tags[i].id);
    if (!known || sightings[tags[i].id] > 1) continue;
    for (int corner = 0; corner < 4; ++corner)
      points.push_back({known->corners_object[corner], tags[i].corners[corner], i});
  }
  return points;
}

int count_tags(const std::vector<Correspondence>& points) {
  return static_cast<int>(points.size() / 4);
}

std::optional<Rigid3> solve_sqpnp(const Camera& camera, std::span<const Correspondence> points) {
  std::vector<cv::Point3d> object;
  std::vector<cv::Point2d> normalised;
  for (const Correspondence& c : points) {
    const auto ray = camera.ray(c.pixel);
    if (!ray || ray->z() < 0.05) continue;
    object.emplace_back(c.point_object.x(), c.point_object.y(), c.point_object.z());
    normalised.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
  }
  if (object.size() < 4) return std::nullopt;
  cv::Mat rotation_vector, translation, rotation;
  try {
    if (!cv::solvePnP(object, normalised, cv::Matx33d::eye(), cv::noArray(), rotation_vector, translation, false,
                      cv::SOLVEPNP_SQPNP))
      return std::nullopt;
    cv::Rodrigues(rotation_vector, rotation);
  } catch (const cv::Exception&) {
    return std::nullopt;  // degenerate corners
  }
  Eigen::Matrix3d r;
  for (int i = 0; i < 9; ++i) r(i / 3, i % 3) = rotation.at<double>(i / 3, i % 3);
  const Eigen::Vector3d t(translation.at<double>(0), translation.at<double>(1), translation.at<double>(2));
  if (!r.allFinite() || !t.allFinite()) return std::nullopt;
  return Rigid3{Eigen::Quaterniond(r).normalized(), t};
}

/// The pose under which a plane seen from far looks nearly the same: its normal mirrored at the line of sight.
Rigid3 mirrored_pose(const Rigid3& pose, std::span<const Correspondence> points) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Correspondence& c : points) centre += c.point_object / points.size();
  const Eigen::Vector3d centre_camera = pose * centre;
  const Eigen::AngleAxisd half_turn(M_PI, centre_camera.normalized());
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(half_turn) * pose.rotation * Eigen::Quaterniond(0, 0, 0, 1);  // about the stage's normal
  return {rotation.normalized(), centre_camera - rotation * centre};
}

/// RMS reprojection error of each tag among `points`, in their order.
std::vector<double> tag_residuals(const Camera& camera, const std::vector<Correspondence>& points, const Rigid3& pose) {
  std::vector<double> residuals;
  for (std::size_t i = 0; i < points.size(); i += 4) {
    double sum = 0;
    for (std::size_t k = i; k < i + 4; ++k) {
      const auto pixel = camera.project(pose * points[k].point_object);
      sum += pixel ? (*pixel - points[k].pixel).squaredNorm() : INFINITY;
    }
    residuals.push_back(std::sqrt(sum / 4));
  }
  return residuals;
}

std::vector<Correspondence> without_tag(const std::vector<Correspondence>& points, int index) {
  std::vector<Correspondence> rest = points;
  rest.erase(rest.begin() + 4 * index, rest.begin() + 4 * index + 4);
  return rest;
}

/// Solves from all tags; where the result fits badly, one of them may be so wrong that it spoilt the start: then from
/// all but each in turn, and the pose that most tags agree with wins.
std::optional<RefinedPose> solve_robustly(const Camera& camera, const std::vector<Correspondence>& points,
                                          const PoseOptions& options) {
  const auto misfit = [&](const RefinedPose& pose) {
    return median(tag_residuals(camera, points, pose.camera_from_object));
  };
  auto best = solve_pose_of_points(camera, points, options.huber_px);
  if ((best && misfit(*best) <= options.max_rms_px) || count_tags(points) <= options.min_tags) return best;
  for (int left_out = 0; left_out < count_tags(points); ++left_out) {
    const auto pose = solve_pose_of_points(camera, without_tag(points, left_out), options.huber_px);
    if (pose && (!best || misfit(*pose) < misfit(*best))) best = pose;
  }
  return best;
}

/// Removes the tags that disagree with the others. False when there are none.
bool drop_outliers(const Camera& camera, std::vector<Correspondence>& points, const Rigid3& pose,
                   const PoseOptions& options) {
  const std::vector<double> residuals = tag_residuals(camera, points, pose);
  const double middle = median(std::vector(residuals));
  std::vector<double> deviations;
  for (const double r : residuals) deviations.push_back(std::abs(r - middle));
  const double limit = std::max(middle + options.drop_mads * kMadToSigma * median(deviations), options.drop_floor_px);
  std::vector<Correspondence> kept;
  for (std::size_t i = 0; i < residuals.size(); ++i)
    if (residuals[i] <= limit) kept.insert(kept.end(), points.begin() + 4 * i, points.begin() + 4 * i + 4);
  if (kept.size() == points.size() || count_tags(kept) < options.min_tags) return false;
  points = std::move(kept);
  return true;
}

void note_residuals(const Camera& camera, const StageLayout& stage, const std::vector<Correspondence>& used,
                    const Rigid3& pose, std::vector<TagObservation>& tags) {
  for (TagObservation& tag : tags) {
    tag.used = false;
    tag.residual_px = 0;
    const StageTag* known = stage.find(tag.id);
    if (!known) continue;
    double sum = 0;
    int count = 0;
    for (int corner = 0; corner < 4; ++corner)
      if (const auto pixel = camera.project(pose * known->corners_object[corner])) {
        sum += (*pixel - tag.corners[corner]).squaredNorm();
        ++count;
      }
    if (count > 0) tag.residual_px = std::sqrt(sum / count);
  }
  for (const Correspondence& c : used) tags[c.tag].used = true;
}

}  // namespace

std::vector<RefinedPose> poses_of_points(const Camera& camera, std::span<const Correspondence> points,
                                         double huber_px) {
  std::vector<RefinedPose> poses;
  const auto start = solve_sqpnp(camera, points);
  if (!start) return poses;
  for (const Rigid3& from : {*start, mirrored_pose(*start, points)})
    if (auto pose = refine_pose(camera, points, from, huber_px)) poses.push_back(*std::move(pose));
  if (poses.size() == 2 && poses[1].cost < poses[0].cost) std::swap(poses[0], poses[1]);
  return poses;
}

std::optional<RefinedPose> solve_pose_of_points(const Camera& camera, std::span<const Correspondence> points,
                                                double huber_px) {
  const std::vector<RefinedPose> poses = poses_of_points(camera, points, huber_px);
  return poses.empty() ? std::nullopt : std::optional(poses.front());
}

PoseEstimate solve_pose(const Camera& camera, const StageLayout& stage, std::vector<TagObservation>& tags,
                        const PoseOptions& options) {
  PoseEstimate estimate;
  std::vector<Correspondence> points = stage_correspondences(stage, tags);
  if (count_tags(points) < std::max(1, options.min_tags)) {
    estimate.status = points.empty() ? PoseStatus::kNoTags : PoseStatus::kTooFewTags;
    return estimate;
  }
  estimate.status = PoseStatus::kInconsistent;
  const std::size_t offered = points.size();
  auto pose = solve_robustly(camera, points, options);
  for (int round = 0; pose && round < kMaxDropRounds; ++round) {
    if (!drop_outliers(camera, points, pose->camera_from_object, options)) break;
    pose = refine_pose(camera, points, pose->camera_from_object, options.huber_px);
  }
  if (!pose) return estimate;
  const auto weighed = weigh_edges(camera, points, pose->camera_from_object, options.noise_floor_px);
  const Rigid3 camera_from_object = weighed ? weighed->camera_from_object : pose->camera_from_object;
  note_residuals(camera, stage, points, camera_from_object, tags);

  double sum = 0;
  for (const double r : tag_residuals(camera, points, camera_from_object)) sum += 4 * r * r;
  const double rms = std::sqrt(sum / points.size());
  if (!weighed || !(rms <= options.max_rms_px) || 2 * points.size() <= offered) return estimate;
  estimate.status = PoseStatus::kTracked;
  estimate.camera_from_object = weighed->camera_from_object;
  estimate.covariance = weighed->covariance;
  estimate.reprojection_rms_px = rms;
  estimate.tags_used = count_tags(points);
  return estimate;
}

double point_uncertainty_px(const Camera& camera, const PoseEstimate& pose, const Eigen::Vector3d& point_object) {
  const auto projection = project_with_jacobian(camera, pose.camera_from_object, point_object);
  if (!projection) return 0;
  const Eigen::Matrix2d covariance = projection->jacobian * pose.covariance * projection->jacobian.transpose();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1]);
}

}  // namespace sheen
