// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"

namespace sheen {

struct Correspondence {
  Eigen::Vector3d point_object;
  Eigen::Vector2d pixel;
  int tag = -1;  ///< index of the observation it belongs to
};

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Jacobian26 = Eigen::Matrix<double, 2, 6>;

/// Pixel of an object point and its derivative by a left step (w, t) of the pose. Empty where the lens shows nothing.
struct Projection {
  Eigen::Vector2d pixel;
  Jacobian26 jacobian;
};
std::optional<Projection> project_with_jacobian(const Camera& camera, const Rigid3& camera_from_object,
                                                const Eigen::Vector3d& point_object);

struct RefinedPose {
  Rigid3 camera_from_object;
  double cost = 0;      ///< sum of Huber losses, px^2
  Matrix6 information;  ///< J^T J at the solution, unweighted
};

/// Levenberg-Marquardt on the Huber loss of the reprojection error. Empty when a point cannot be projected from the
/// start, or the points do not determine a pose.
std::optional<RefinedPose> refine_pose(const Camera& camera, std::span<const Correspondence> points,
                                       const Rigid3& start, double huber_px);

}  // namespace sheen
