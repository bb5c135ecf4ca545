// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"

namespace sheen {

/// Continues each surface's colours by a pixel over its edge, so that sampling beside it never reads the mixed pixels
/// of the edge, nor what lies beyond: pixels that touch an edge take the mean of the neighbours that touch none, which
/// show the same surface. Others stay as they are, and so do pixels that have no such neighbour.
///
/// `from_edge`: of the whole image, 0 where a pixel touches an edge (SurfaceView). `left`, `top`: pixel of the whole
/// image at (0, 0) of `pixels`, which may be a part of it and has any number of channels.
void fill_edges(const ImageU8& from_edge, int left, int top, ImageF& pixels);

}  // namespace sheen
