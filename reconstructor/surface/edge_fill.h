// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image.h"

namespace sheen {

/// How many pixels beyond the safe ones are filled: as many as a kernel of 4 x 4 reads round a safe pixel.
inline constexpr int kFilledPixels = 2;

/// Continues a surface's colours over its edge, so that sampling beside it never reads the mixed pixels of the edge,
/// nor a background or what a mask hides: pixels that touch a safe one take the mean of the safe ones that they touch,
/// those that touch these the mean of these. Between two surfaces both are continued up to the edge.
///
/// `safe_depth`: of the whole image, > 0 where a pixel is safe (SurfaceView). `left`, `top`: pixel of the whole image
/// at (0, 0) of `pixels`, which may be a part of it and has any number of channels. Other pixels stay as they are.
void fill_edges(const ImageF& safe_depth, int left, int top, ImageF& pixels);

}  // namespace sheen
