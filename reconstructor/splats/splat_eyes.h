// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// From where splats are fitted to a model, and judged: pinhole cameras that see the whole object, or 90 degrees of it.
struct SplatEyes {
  std::vector<PosedCamera> near;   ///< between the eyes of the model's images
  std::vector<PosedCamera> round;  ///< all round the object
  std::vector<PosedCamera> check;  ///< more of the first, or where the model has no images of the second
};

/// `images`: of the model. `splat_width`: metres on the object; pixels are no finer than what splats can show, nor than
/// the images'.
SplatEyes splat_eyes(const BoundingSphere& object, std::span<const PosedCamera> images, double splat_width);

}  // namespace sheen
