// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "reconstructor/lumigraph_file/intrinsic_view.h"
#include "reconstructor/models/intrinsic_lumigraph/captured_view.h"

namespace sheen {

/// Where the lights of a view arrive, 255, or not, 0; next to the other class, where a pixel may show both, the part by
/// its brightness, 1..254. Per pixel a matt surface is fitted to those lights that do not fall below it; how much
/// darker an image is than that surface, in logarithms, is split by Otsu's threshold over all lights together (001
/// sec. 4.4, which splits the illumination of each light by itself: near lamps make that vary more across the ground
/// than shadow does). What faces away from a lamp, by the depth map, is in shadow as well (001 sec. 4.5: AND with
/// geometry). Needs depth and radiance.
std::vector<ImageU8> shadow_masks(const CapturedView& view, const LightSet& lights);

}  // namespace sheen
