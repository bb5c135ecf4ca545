// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/hemisphere_frame.h"

#include <Eigen/Geometry>

namespace sheen {

Eigen::Matrix3f hemisphere_frame(const Eigen::Vector3f& normal) {
  const Eigen::Vector3f n = normal.normalized();
  const Eigen::Vector3f tangent = n.unitOrthogonal();
  Eigen::Matrix3f frame;
  frame << tangent.transpose(), n.cross(tangent).transpose(), n.transpose();
  return frame;
}

}  // namespace sheen
