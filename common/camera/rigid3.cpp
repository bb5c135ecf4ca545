// SPDX-License-Identifier: Apache-2.0
#include "common/camera/rigid3.h"

namespace sheen {

Rigid3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  Eigen::Vector3d right = forward.cross(up);
  if (right.norm() < 1e-9) right = forward.unitOrthogonal();  // looking along `up`: any roll is as good
  right.normalize();
  const Eigen::Vector3d down = forward.cross(right);
  Eigen::Matrix3d camera_from_object;
  camera_from_object << right.transpose(), down.transpose(), forward.transpose();
  return {Eigen::Quaterniond(camera_from_object).normalized(), -camera_from_object * eye};
}

}  // namespace sheen
