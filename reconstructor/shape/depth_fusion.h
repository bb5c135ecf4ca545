// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/shape/block_field.h"
#include "reconstructor/shape/depth_map.h"
#include "reconstructor/shape/shape_view.h"
#include "reconstructor/shape/visual_hull.h"

namespace sheen {

/// What the views hold for the surface, put together: their mean signed distance, weighted by how straight and how
/// surely each sees it (Curless and Levoy 1996). What a view looks through is outside. The hull stands in where no view
/// says anything; without outlines only what lies not far behind surfaces is taken for the object. Outside of the hull
/// is outside, if `hull_is_sure`, else unless several views see a surface there.
BlockField fused_surface(std::span<const ShapeView> views, std::span<const DepthMap> depths, const VisualHull& hull,
                         bool hull_is_sure, const Lattice& lattice, const ForEach& for_each);

/// How many views see a surface within `reach` of a point, and no other before it.
int views_of(const Eigen::Vector3d& point, std::span<const ShapeView> views, std::span<const DepthMap> depths,
             double reach);

}  // namespace sheen
