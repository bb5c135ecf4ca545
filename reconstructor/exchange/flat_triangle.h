// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace sheen {

/// A triangle in the plane of a picture, in pixels: (0, 0) is the upper left corner of the first.
struct FlatTriangle {
  std::array<Eigen::Vector2f, 3> corners;

  /// Barycentric weights of a point, which may lie outside; NaN where the triangle has no area.
  Eigen::Vector3f weights_of(const Eigen::Vector2f& point) const {
    const auto cross = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) { return a.x() * b.y() - a.y() * b.x(); };
    const Eigen::Vector2f ab = corners[1] - corners[0], ac = corners[2] - corners[0], ap = point - corners[0];
    const float area = cross(ab, ac), b = cross(ap, ac) / area, c = cross(ab, ap) / area;
    return {1 - b - c, b, c};
  }

  /// Calls visit(x, y, weights) for the pixels of a picture whose centres are no further than `margin` pixels off the
  /// triangle's bounding box.
  template <typename Visit>
  void for_each_pixel(int width, int height, float margin, const Visit& visit) const {
    const Eigen::Vector2f low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
    const Eigen::Vector2f high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
    const auto first = [&](float at) { return std::max(0, static_cast<int>(std::ceil(at - margin - 0.5f))); };
    const auto last = [&](float at, int size) {
      return std::min(size - 1, static_cast<int>(std::floor(at + margin - 0.5f)));
    };
    for (int y = first(low.y()); y <= last(high.y(), height); ++y)
      for (int x = first(low.x()); x <= last(high.x(), width); ++x)
        visit(x, y, weights_of({static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}));
  }
};

}  // namespace sheen
