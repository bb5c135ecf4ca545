// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"
#include "tracker/pose/reprojection.h"

namespace sheen {

struct PoseOptions {
  int min_tags = 2;              ///< one tag alone flips in 2 to 10 % of the frames
  double huber_px = 0.3;         ///< a few times the error of a refined corner
  double drop_mads = 5;          ///< tags whose RMS lies so many (scaled) MADs above the median are dropped ...
  double drop_floor_px = 0.1;    ///< ... if it is above this at all
  double max_rms_px = 1.5;       ///< beyond it the tags do not show one rigid stage
  double noise_floor_px = 0.01;  ///< of one point of an edge, see weigh_edges; images without noise leave 0.02
};

/// Pose of the stage from all its tags at once: SQPNP on undistorted corners, Huber Levenberg-Marquardt on reprojection
/// through the lens (also from the mirrored pose of the plane, the better one wins), tags dropped by their median
/// absolute deviation, solved again; at last the corners are weighed as edges err, which gives the covariance, too
/// (edge_weights.h).
/// Tags that are not on the stage, or that were seen twice, are not used; every tag gets its `residual_px` and `used`.
PoseEstimate solve_pose(const Camera& camera, const StageLayout& stage, std::vector<TagObservation>& tags,
                        const PoseOptions& options = {});

/// Pose from points near the plane z = 0, without dropping any: SQPNP, Levenberg-Marquardt, also from the mirrored pose
/// of the plane. Empty where they do not determine one.
std::optional<RefinedPose> solve_pose_of_points(const Camera& camera, std::span<const Correspondence> points,
                                                double huber_px);

/// The pose and, where it is another minimum, the one mirrored at the line of sight; the better one first.
std::vector<RefinedPose> poses_of_points(const Camera& camera, std::span<const Correspondence> points, double huber_px);

/// Standard deviation (pixels, the worst direction) with which a point of the object appears under this pose.
double point_uncertainty_px(const Camera& camera, const PoseEstimate& pose, const Eigen::Vector3d& point_object);

/// The pose moved by a small rotation vector (rad) and translation (m) on its left: the parameters of the covariance.
Rigid3 moved(const Rigid3& camera_from_object, const Eigen::Matrix<double, 6, 1>& step);

}  // namespace sheen
