// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/depth_points.h"

namespace sheen {

void for_each_point(const PosedCamera& from, const ImageF& depth, const ForEach& for_each,
                    const std::function<void(std::size_t, const Eigen::Vector3f&)>& visit) {
  const DepthPoints points(from);
  const auto width = static_cast<std::size_t>(depth.width());
  for_each(static_cast<std::size_t>(depth.height()), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < depth.width(); ++x)
      visit(row * width + static_cast<std::size_t>(x), points.at(x, y, depth.at(x, y)));
  });
}

}  // namespace sheen
