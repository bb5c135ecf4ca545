// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/pixel_rays.h"

#include <tbb/parallel_for.h>

#include <limits>

namespace sheen {

void PixelRays::use(const Camera& camera) {
  if (camera == camera_) return;
  camera_ = camera;
  bent_ = {};
  if (camera.is_pinhole()) return;
  bent_.resize(static_cast<std::size_t>(camera.width) * camera.height);
  tbb::parallel_for(0, camera.height, [&](int y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.ray({double(x), double(y)});
      bent_[static_cast<std::size_t>(y) * camera.width + x] =
          ray && ray->z() > 1e-3 ? Eigen::Vector2f((ray->head<2>() / ray->z()).cast<float>())
                                 : Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
    }
  });
}

void PixelRays::read(int x, int y, std::span<Eigen::Vector3f> rays) const {
  if (!bent_.empty()) {
    const Eigen::Vector2f* bent = bent_.data() + static_cast<std::size_t>(y) * camera_.width + x;
    for (Eigen::Vector3f& ray : rays) {
      ray = {bent->x(), bent->y(), 1};
      ++bent;
    }
    return;
  }
  const auto ray_y = static_cast<float>((y - camera_.cy) / camera_.fy);
  for (Eigen::Vector3f& ray : rays) ray = {static_cast<float>((x++ - camera_.cx) / camera_.fx), ray_y, 1};
}

}  // namespace sheen
