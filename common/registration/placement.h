// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/camera/posed_camera.h"
#include "common/geometry/similarity.h"

namespace sheen {

/// A small change of where a mesh stands: rotation vector (rad), translation (m), logarithm of the scale, all in the
/// stage's axes about a centre.
using PlacementStep = Eigen::Matrix<double, 7, 1>;
using PlacementMatrix = Eigen::Matrix<double, 7, 7>;

/// Where a mesh stands, and how well that is known.
struct Placement {
  Similarity stage_from_mesh;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();      ///< stage frame, metres: the covariance is about it
  PlacementMatrix covariance = PlacementMatrix::Zero();  ///< of a `PlacementStep`
};

/// x -> centre + translation + e^s R(rotation) (x - centre), after `stage_from_mesh`.
Similarity moved(const Similarity& stage_from_mesh, const Eigen::Vector3d& centre, const PlacementStep& step);
/// The step that leads from one to the other: inverse of `moved`.
PlacementStep step_between(const Similarity& from, const Similarity& to, const Eigen::Vector3d& centre);

/// Derivative of a point of the mesh, which stands at `stage_point`, by a step.
Eigen::Matrix<double, 3, 7> point_derivative(const Eigen::Vector3d& stage_point, const Eigen::Vector3d& centre);

/// The same placement, its covariance about another centre.
Placement about(const Placement& placement, const Eigen::Vector3d& centre);

/// Pixel of a point of the stage, and its derivative by the point. False where the camera does not see it.
bool project_with_derivative(const PosedCamera& view, const Eigen::Vector3d& stage_point, Eigen::Vector2d& pixel,
                             Eigen::Matrix<double, 2, 3>& derivative);

/// The camera as the mesh sees it. A mesh is never moved: its place in memory, its rays' tree and its samples stay.
/// Lengths in the mesh's own unit.
PosedCamera in_mesh_frame(const PosedCamera& view, const Similarity& stage_from_mesh);

}  // namespace sheen
