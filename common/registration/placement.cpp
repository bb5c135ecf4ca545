// SPDX-License-Identifier: Apache-2.0
#include "common/registration/placement.h"

#include <Eigen/Geometry>
#include <cmath>

namespace sheen {

Similarity moved(const Similarity& stage_from_mesh, const Eigen::Vector3d& centre, const PlacementStep& step) {
  const double angle = step.head<3>().norm();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (angle > 0) rotation = Eigen::AngleAxisd(angle, step.head<3>() / angle).toRotationMatrix();
  const double grow = std::exp(step[6]);
  Similarity after;
  after.scale = grow * stage_from_mesh.scale;
  after.rotation = Eigen::Quaterniond(rotation * stage_from_mesh.rotation).normalized().toRotationMatrix();
  after.translation = centre + step.segment<3>(3) + grow * (rotation * (stage_from_mesh.translation - centre));
  return after;
}

PlacementStep step_between(const Similarity& from, const Similarity& to, const Eigen::Vector3d& centre) {
  const Eigen::AngleAxisd rotation(Eigen::Matrix3d(to.rotation * from.rotation.transpose()));
  const double grow = to.scale / from.scale;
  PlacementStep step;
  step.head<3>() = rotation.angle() * rotation.axis();
  step.segment<3>(3) = to.translation - centre - grow * (rotation.toRotationMatrix() * (from.translation - centre));
  step[6] = std::log(grow);
  return step;
}

Eigen::Matrix<double, 3, 7> point_derivative(const Eigen::Vector3d& stage_point, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d arm = stage_point - centre;
  Eigen::Matrix<double, 3, 7> derivative;
  derivative << 0, arm.z(), -arm.y(), 1, 0, 0, arm.x(),  //
      -arm.z(), 0, arm.x(), 0, 1, 0, arm.y(),            //
      arm.y(), -arm.x(), 0, 0, 0, 1, arm.z();
  return derivative;
}

Placement about(const Placement& placement, const Eigen::Vector3d& centre) {
  PlacementMatrix change = PlacementMatrix::Identity();
  change.middleRows<3>(3) = point_derivative(centre, placement.centre);
  return {placement.stage_from_mesh, centre, change * placement.covariance * change.transpose()};
}

bool project_with_derivative(const PosedCamera& view, const Eigen::Vector3d& stage_point, Eigen::Vector2d& pixel,
                             Eigen::Matrix<double, 2, 3>& derivative) {
  const Eigen::Vector3d point = view.camera_from_object * stage_point;
  const auto at = view.camera.project(point);
  if (!at) return false;
  pixel = *at;
  const double h = 1e-5 * point.norm();
  Eigen::Matrix<double, 2, 3> by_camera_point;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d shift = h * Eigen::Vector3d::Unit(axis);
    const auto ahead = view.camera.project(point + shift), behind = view.camera.project(point - shift);
    if (!ahead || !behind) return false;
    by_camera_point.col(axis) = (*ahead - *behind) / (2 * h);
  }
  derivative = by_camera_point * view.camera_from_object.rotation.toRotationMatrix();
  return true;
}

PosedCamera in_mesh_frame(const PosedCamera& view, const Similarity& stage_from_mesh) {
  const Rigid3 turned{Eigen::Quaterniond(stage_from_mesh.rotation),
                      stage_from_mesh.translation};  // mesh, scaled -> stage
  Rigid3 camera_from_mesh = view.camera_from_object * turned;
  camera_from_mesh.translation /= stage_from_mesh.scale;  // a projection does not know the unit
  return {view.camera, camera_from_mesh};
}

}  // namespace sheen
