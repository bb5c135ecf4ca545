// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/image/image.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// Pixels from the outline of a view, negative on what may be the object; empty where nothing is background or nothing
/// object. NaN: of what is unknown beside a sheet, nothing is said.
ImageF distance_from_outline(const ShapeView& view);

/// Between pixels; beyond the rim of the image, as at the rim.
float bilinear(const ImageF& image, float x, float y);

}  // namespace sheen
