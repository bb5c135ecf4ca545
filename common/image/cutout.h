// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"
#include "common/image/raw_image.h"

namespace sheen {

/// 8-bit colours, 1 or 3 channels, and the alpha that stands beside them: 1 channel, empty where there is none.
struct Cutout {
  ImageU8 colours, alpha;
};

/// An image and, where it says so itself, which of its pixels show the object: 255, else 0; empty: it says nothing.
struct MaskedImage {
  RawImage image;
  ImageU8 mask;
};

/// The object by an alpha channel: 255 where it covers at least half of a pixel, else 0. Empty where that is every
/// pixel: such an alpha says nothing.
ImageU8 mask_of_alpha(const ImageU8& alpha);

/// The object by a picture that was drawn to be a mask: 255 on it, else 0. An alpha that says something is the mask.
/// Else whatever is not black is object: white, grey, or the colour or number of any object. With `lossy`, where black
/// does not stay black (JPEG), what is brighter than half of the brightest.
ImageU8 mask_of_drawing(const Cutout& drawing, bool lossy);

}  // namespace sheen
