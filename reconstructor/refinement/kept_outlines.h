// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "reconstructor/refinement/mesh_refinement.h"

namespace sheen {

/// An object covers its masks: what a mesh covered of a mask as it was given, it must cover when it is refined. Takes
/// vertices back towards where they were given, about as far as covers again what they uncovered. Images without a mask
/// say nothing. `footprints`: width of a pixel on the surface, metres, per vertex.
void keep_outlines_covered(const Mesh& given, const RefinementImages& images, std::span<const float> footprints,
                           RefinedMesh& refined);

}  // namespace sheen
