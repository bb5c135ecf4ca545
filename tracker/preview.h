// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "common/image/raw_image.h"
#include "tracker/fiducials/tag_detector.h"

namespace sheen {

/// What can be said of an image before anything is calibrated.
struct ImageLook {
  /// Squared differences of neighbouring pixels over those of pixels eight apart, of pictures of half the size: 0 to
  /// about 1, more is sharper. Neither exposure nor contrast changes it; compare it with itself while turning the lens.
  double focus = 0;
  double mean = 0;     ///< of full scale, 0..1
  double clipped = 0;  ///< part of the pixels at full scale
  double dark = 0;     ///< part of the pixels below a hundredth of full scale
  std::size_t tags = 0;
};

/// Of an 8-bit image, Bayer or not.
ImageLook inspect(const RawImage& image, TagDetector& detector);

/// What to change, for a person; empty: nothing.
std::string advice(const ImageLook& look);

/// The picture as a person wants to see it: grey or sRGB, 8 bit. Linear images are encoded.
ImageU8 viewable(const RawImage& image);

}  // namespace sheen
