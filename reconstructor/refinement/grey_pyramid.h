// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/capture/capture.h"
#include "common/image/image.h"

namespace sheen {

/// Encoded luminance of an image at halving sizes. Pixels that are not to be used (mask, not finite) are NaN, and so is
/// whatever is interpolated from one of them or lies outside the image.
class GreyPyramid {
 public:
  explicit GreyPyramid(const Capture& capture);

  /// The level on which samples `step_px` pixels of the full image apart neither skip nor repeat detail.
  int level_for(float step_px) const;
  /// Bilinear; `x`, `y` in pixels of the full image.
  float sample(int level, float x, float y) const;

 private:
  std::vector<ImageF> levels_;
};

}  // namespace sheen
