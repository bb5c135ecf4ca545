// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"

namespace sheen {

/// What takes the lens out of a fixed camera's images, once for each: a field's pictures are flat. Of a camera without
/// distortion nothing changes.
class Undistortion {
 public:
  Undistortion() = default;
  /// Throws ConfigError for a lens that sees too far to the side for a flat picture.
  explicit Undistortion(const PosedCamera& camera);

  /// The camera of the flat pictures, at the same place, as large as the image: it sees the largest rectangle of which
  /// the lens shows all. What the lens shows beside it is left out.
  const PosedCamera& camera() const { return flat_; }
  /// An image of the lens, linear radiance of 3 channels, as the flat camera has it: cubic interpolation.
  ImageF of(ImageF image) const;

 private:
  PosedCamera flat_;
  std::vector<Eigen::Vector2f> places_;  ///< in the image, of each pixel; empty: all stay
};

}  // namespace sheen
