// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// Pixels from the rim of what has this mark or a higher one (`Outline`), negative on it; empty where all or nothing
/// has.
ImageF distance_from_rim(const ImageU8& outline, Outline least);

/// Pixels from the background of a view, negative on what may be the object; empty where nothing is background or
/// nothing object. NaN: of what is unknown beside a sheet, nothing is said.
ImageF distance_from_background(const ShapeView& view);

/// Between pixels; beyond the rim of the image, as at the rim.
float bilinear(const ImageF& image, float x, float y);

}  // namespace sheen
