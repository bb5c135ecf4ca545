// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/camera/camera.h"

namespace sheen {

/// `Camera::project` of many points at once, in single precision (to 1e-6 of the picture's size): pixels of the points
/// (x, y, z) in camera coordinates, NaN where `Camera::project` is empty. All spans are of one length.
void project(const Camera& camera, std::span<const float> x, std::span<const float> y, std::span<const float> z,
             std::span<float> pixel_x, std::span<float> pixel_y);

}  // namespace sheen
