// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// One scalar exposure gain of an image from many surfaces: each gives the log of (radiance seen / radiance expected).
/// The median is what most surfaces agree on, so a highlight that moved cannot pull it; the prior towards 1 is weak and
/// only decides when few surfaces speak or they disagree. Returns the gain by which the image is brighter than
/// expected. NaN entries are left out; the span is overwritten.
float robust_gain(std::span<float> log_ratios);

/// What automatic exposure would have chosen elsewhere, from what it chose at `eyes` (object frame), by the kernel that
/// foretells each best from the others. Empty when all gains were known (log gain 0).
ExposureField interpolated_exposure(const Eigen::Vector3f& centre, std::span<const Eigen::Vector3d> eyes,
                                    std::span<const float> log_gains);

}  // namespace sheen
