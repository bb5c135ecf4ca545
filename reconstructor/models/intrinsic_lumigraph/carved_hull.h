// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "reconstructor/lumigraph_file/intrinsic_view.h"
#include "reconstructor/lumigraph_file/shadow_hull.h"

namespace sheen {

/// Of views with depth and masks of where each light arrives.
ShadowHull carved_hull(std::span<const IntrinsicView* const> views, const LightSet& lights);

}  // namespace sheen
