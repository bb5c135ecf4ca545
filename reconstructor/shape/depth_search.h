// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstructor/shape/depth_map.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// Finds the surface that a view sees within `range`, where its neighbours look most alike: what a pixel has found is
/// tried for the pixels beside it, and varied by chance (PatchMatch; Bleyer, Rhemann, Rother 2011). `seed`: of the
/// chance.
DepthMap search_depth(const ShapeView& view, const std::vector<const ShapeView*>& neighbours, const DepthRange& range,
                      std::uint64_t seed);

/// Goes on from what was found, now that the neighbours' depths are known, too: it is to agree with these.
DepthMap search_depth_again(const ShapeView& view, const std::vector<const ShapeView*>& neighbours,
                            const std::vector<const ImageF*>& depths, const DepthRange& range, DepthMap found,
                            std::uint64_t seed);

/// How many neighbours' surfaces lead from each pixel to a place of theirs and back to within a pixel, at a depth that
/// differs by no more than 0.5 %; 0 where the cost is high.
ImageU8 agreeing_neighbours(const ShapeView& view, const DepthMap& found,
                            const std::vector<const ShapeView*>& neighbours, const std::vector<const ImageF*>& depths);

}  // namespace sheen
