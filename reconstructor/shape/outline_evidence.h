// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// What a background without pattern looks like in an image.
struct PlainBackground {
  bool found = false;
  float level = 0;   ///< grey, 0 to 255
  float spread = 0;  ///< grey levels within which it stays
};

/// From the rim of a whole image: nearly all of it must be of one grey, and something in the middle of another.
PlainBackground plain_background(const ShapeView& whole);

/// Marks the background in a view without a mask: what is of its grey and hangs together with the rim of the view. A
/// part of the object in shadow may be as black as a background behind it, so what is of its grey elsewhere is
/// unknown.
void mark_background(const PlainBackground& background, ShapeView& view);

}  // namespace sheen
