// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"

namespace sheen {

/// For each camera those others, `most` at most and best first, whose images tell depth about a place best: from
/// directions 5 to 30 degrees away, on different sides, and from about as near.
std::vector<std::vector<std::size_t>> neighbour_views(std::span<const PosedCamera> cameras,
                                                      const Eigen::Vector3d& place, std::size_t most);

/// `most` of them that stand in directions as different as can be, seen from a place; in their order.
std::vector<std::size_t> spread_views(std::span<const PosedCamera> cameras, const Eigen::Vector3d& place,
                                      std::size_t most);

}  // namespace sheen
