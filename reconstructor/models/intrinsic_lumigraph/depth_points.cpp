// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/depth_points.h"

#include <tbb/parallel_for.h>

namespace sheen {

void for_each_point(const PosedCamera& from, const ImageF& depth,
                    const std::function<void(std::size_t, const Eigen::Vector3f&)>& visit) {
  const DepthPoints points(from);
  const auto width = static_cast<std::size_t>(depth.width());
  tbb::parallel_for(0, depth.height(), [&](int y) {
    for (int x = 0; x < depth.width(); ++x)
      visit(static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x), points.at(x, y, depth.at(x, y)));
  });
}

}  // namespace sheen
