// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"

namespace sheen {

/// Pixels of a picture that show the front of a mesh: 255, else 0. Keeps the rays of the last camera.
class SilhouetteCaster {
 public:
  ImageU8 cast(const PosedCamera& view, const Mesh& mesh, const RayScene& scene);

 private:
  Camera rays_of_;
  std::vector<Eigen::Vector3f> rays_;  ///< camera frame; NaN where the lens has none
};

/// Distance of each pixel from the outline of a silhouette, pixels: positive inside, 0 half way between an inner and an
/// outer pixel.
ImageF distance_from_outline(const ImageU8& silhouette);

}  // namespace sheen
