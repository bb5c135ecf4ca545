// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/splats.h"

#include "reconstructor/numerics/spherical_harmonics.h"

namespace sheen {

Eigen::VectorXf splat_harmonics(const Eigen::Vector3f& direction, int terms) {
  Eigen::VectorXf values = spherical_harmonics(direction).head(terms);
  for (int l = 1; l * l < terms; ++l)
    for (int m = 1; m <= l; m += 2) {
      values[l * l + l + m] *= -1;
      values[l * l + l - m] *= -1;
    }
  return values;
}

}  // namespace sheen
