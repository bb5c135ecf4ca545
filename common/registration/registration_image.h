// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/image/image.h"

namespace sheen {

/// What registration looks at of a capture. Large images are halved until they are `kWidestRegistration_px` wide.
struct RegistrationImage {
  std::string name;
  PosedCamera view;  ///< of the size of `grey`
  ImageF grey;       ///< encoded luminance
  ImageU8 mask;      ///< empty, or 255 on the object
};
inline constexpr int kWidestRegistration_px = 1600;
RegistrationImage registration_image(const Capture& capture);

/// The detail of an image at halving sizes: what differs from the surroundings, over the contrast of the surroundings.
/// So neither exposure nor a shadow matters, and where there is nothing but noise there is noise of the same size: an
/// empty wall agrees with nothing.
class DetailPyramid {
 public:
  /// `finest`: there is nothing on levels below it.
  explicit DetailPyramid(const ImageF& grey, int finest = 0);
  int levels() const { return static_cast<int>(levels_.size()); }
  /// Bilinear value and its gradient per pixel of the full image; `x`, `y` likewise. False near the border, and on
  /// levels that are not there.
  bool sample(int level, double x, double y, float& value, Eigen::Vector2f& gradient) const;

 private:
  std::vector<ImageF> levels_;
};

}  // namespace sheen
