// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "common/image/image.h"

namespace sheen {

/// How a lens darkens the image away from its middle: 1 + k[0] r^2 + k[1] r^4 + k[2] r^6, where r is the distance to
/// the centre in units of half the image's diagonal.
struct Vignette {
  double cx = 0, cy = 0;  ///< pixels
  std::array<double, 3> k{};

  bool none() const { return k == std::array<double, 3>{}; }
  double at(double x, double y, ImageSize size) const;
  bool operator==(const Vignette&) const = default;
};

/// What a camera makes of light, as `sheen-tracker calibrate photometric` measured it. The radiance of a pixel is
/// white_balance * response[value] / vignette. It takes the place of an image's transfer and of its exposure's black
/// level and white balance.
struct Photometry {
  /// Light of each 8-bit value: 0 at black and below, 1 at 255, and never falls. Of deeper images the values between
  /// lie on lines between these.
  std::array<float, 256> response{};
  Vignette vignette;
  std::array<float, 3> white_balance{1, 1, 1};
  float saturation = 1;  ///< of full scale: from here on a value says only that there was at least so much light

  bool operator==(const Photometry&) const = default;
};

/// Empty when it is usable for images of this size, else which field is wrong and why.
std::string validation_error(const Photometry& photometry, ImageSize size);

}  // namespace sheen
