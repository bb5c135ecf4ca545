// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <span>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"

namespace sheen {

/// What this share of the cameras, or more, see round the point that their axes pass nearest to. Throws Error where
/// they show no common place: fewer than three, all in one place, or parallel axes.
Eigen::AlignedBox3d box_seen_by(double share, std::span<const PosedCamera> cameras);

/// Where the box lies in a camera's image without its lens, within the image; empty where it is not in it.
PixelBox part_with(const Eigen::AlignedBox3d& box, const PosedCamera& camera);

}  // namespace sheen
