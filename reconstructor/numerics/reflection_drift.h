// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "reconstructor/numerics/spherical_harmonics.h"

namespace sheen {

/// Unit direction that `direction`, from the surface to the eye, is mirrored to about `normal`; both unit vectors.
Eigen::Vector3f mirrored(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal);

/// What all patches share of how their level varies with the view: the light that comes from where a patch would mirror
/// the eye to, a function on the sphere in spherical harmonics. It is the external drift of the kriging between views
/// (`krige`); a patch uses it where that predicts its views better.
struct ReflectionDrift {
  Harmonics coefficients = Harmonics::Zero();

  /// At the direction that `direction`, from the surface to the eye, is mirrored to about `normal`; both unit vectors.
  float at(const Eigen::Vector3f& direction, const Eigen::Vector3f& normal) const;
  /// The same of many directions, 3 x views.
  Eigen::VectorXf at_each(const Eigen::Matrix3Xf& directions, const Eigen::Vector3f& normal) const;
};

}  // namespace sheen
