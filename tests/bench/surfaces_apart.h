// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// How far points of one surface are from another; infinite where there are none.
struct Apart {
  double median_mm = 0, most_mm = 0;  ///< most: of 90 %
};

/// From what cameras see of one surface to all of the other: of 30,000 points, spread evenly, those in sight.
Apart apart(const Mesh& from, const Mesh& to, std::span<const PosedCamera> cameras);

}  // namespace sheen
