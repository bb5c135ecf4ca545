// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "reconstructor/numerics/view_kriging.h"

namespace sheen {

/// How bright an image from a place is expected to be: images of unknown exposure are brought to one level before they
/// are factorized, and what a camera with automatic exposure would have chosen is interpolated from what it chose
/// nearby.
struct ExposureField {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();  ///< of the object: directions run from here to the cameras
  Eigen::Matrix3Xf directions;
  ViewInterpolant log_gain;  ///< 1 x views; empty when all exposures were known
  ViewKernel kernel;

  /// Factor on the decoded radiance for this eye; 1 when exposures were known.
  float at(const Eigen::Vector3d& eye) const;
};

/// What automatic exposure would have chosen elsewhere, from what it chose at `eyes` (object frame), by the kernel that
/// predicts each best from the others. Empty when all gains were known (log gain 0).
ExposureField interpolated_exposure(const Eigen::Vector3f& centre, std::span<const Eigen::Vector3d> eyes,
                                    std::span<const float> log_gains);

}  // namespace sheen
