// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/geometry/mesh.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// Moves the rims of a found surface, where it ends in the views, to the outlines of these. A hull is what all outlines
/// leave: each that is off by a pixel to the inside cuts it, and none that is off to the outside mends it. A rim goes
/// to the median of those that show it; what lies between rims follows, a few triangles far. A vertex goes by twice
/// `pixel` at most: its size on the object, metres.
void move_rims_to_outlines(std::span<const ShapeView> views, double pixel, Mesh& mesh);

}  // namespace sheen
