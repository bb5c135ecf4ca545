// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/image/image.h"

namespace sheen {

/// Whether `bilinear` may be asked for this place, in pixels with integer coordinates at pixel centres.
inline bool inside(const ImageU8& image, const Eigen::Vector2d& p) {
  return p.x() >= 0 && p.y() >= 0 && p.x() < image.width() - 1 && p.y() < image.height() - 1;
}

/// Value between the four pixels around `p`, of an image of one channel.
template <typename Value>
double bilinear(const Image<Value>& image, const Eigen::Vector2d& p) {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
  const double fx = p.x() - x, fy = p.y() - y;
  const Value *r0 = image.row(y) + x, *r1 = image.row(y + 1) + x;
  return (1 - fy) * ((1 - fx) * r0[0] + fx * r0[1]) + fy * ((1 - fx) * r1[0] + fx * r1[1]);
}

}  // namespace sheen
