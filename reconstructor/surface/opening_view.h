// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "common/camera/posed_camera.h"

namespace sheen {

/// How to look at an object first: as the cameras did that it was captured with.
struct OpeningView {
  Eigen::Vector3d up;         ///< unit: mean of what was up in their images
  Eigen::Vector3d direction;  ///< unit, from the object to the camera that is most in the middle of all
};
/// Empty without cameras; `up` is z where they do not agree on one.
std::optional<OpeningView> opening_view(const std::vector<PosedCamera>& cameras, const Eigen::Vector3d& centre);

}  // namespace sheen
