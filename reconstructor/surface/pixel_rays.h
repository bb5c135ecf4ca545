// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/camera/camera.h"

namespace sheen {

/// Rays through a camera's pixel centres, in its frame, z = 1; NaN where the lens has none. What a lens bends is
/// calculated once for each camera.
class PixelRays {
 public:
  /// Not thread-safe.
  void use(const Camera& camera);
  /// From pixel (x, y) to the right, as many as `rays` holds.
  void read(int x, int y, std::span<Eigen::Vector3f> rays) const;

 private:
  Camera camera_;
  std::vector<Eigen::Vector2f> bent_;  ///< per pixel; empty without distortion
};

}  // namespace sheen
