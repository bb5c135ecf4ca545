// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/base/progress.h"
#include "reconstructor/shape/depth_map.h"
#include "reconstructor/shape/object_hull.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// The surface as each view sees it, where two of its neighbours agree.
struct AgreedDepths {
  std::vector<DepthMap> maps;
  double share = 0;  ///< of the pixels in range that are kept
};

/// Searches each view within the hull, twice, and keeps what agrees. Throws Error where the hull is empty.
AgreedDepths find_depths(std::span<const ShapeView> views, const ObjectHull& hull, const StepsDone& progress);

/// The box of what the views see, but for what lies far off, within `box`. Throws Error where they see nothing.
Eigen::AlignedBox3d box_of_seen(std::span<const ShapeView> views, const AgreedDepths& depths,
                                const Eigen::AlignedBox3d& box);

}  // namespace sheen
