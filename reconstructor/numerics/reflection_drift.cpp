// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/reflection_drift.h"

namespace sheen {

Eigen::Vector3f mirrored(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) {
  return (2 * normal.dot(direction) * normal - direction).normalized();
}

float ReflectionDrift::at(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const {
  return coefficients.dot(spherical_harmonics(mirrored(direction, normal)));
}

}  // namespace sheen
