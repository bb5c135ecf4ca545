// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/reflection_drift.h"

namespace sheen {

Eigen::Vector3f mirrored(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) {
  return (2 * normal.dot(direction) * normal - direction).normalized();
}

float ReflectionDrift::at(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const {
  return coefficients.dot(spherical_harmonics(mirrored(direction, normal)));
}

Eigen::VectorXf ReflectionDrift::at_each(const Eigen::Matrix3Xf& directions, const Eigen::Vector3f& normal) const {
  Eigen::VectorXf drift(directions.cols());
  for (Eigen::Index j = 0; j < drift.size(); ++j) drift[j] = at(directions.col(j), normal);
  return drift;
}

}  // namespace sheen
