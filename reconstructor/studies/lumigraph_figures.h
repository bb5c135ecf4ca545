// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/studies/depth_merging.h"
#include "reconstructor/studies/figure.h"
#include "reconstructor/studies/shadow_row.h"
#include "reconstructor/studies/still_life.h"

namespace sheen {

// The experiments of intrinsic lumigraphs (001) on a simulated still life, seen by the central camera. No mesh is
// known. Beside each other stand the exact truth, an intrinsic lumigraph, the paper's own way (`warped_shadows`), and
// linear interpolation of exact pictures. Shadow is where at most half of a lamp's light arrives.

/// Figure 3: depth of the central view in each light, merged over lights in three ways.
Figure figure_merged_depth(const DepthsByLight& depths);

/// Figure 7: shadows of the depth map, and of the images, in two captured lights and between them.
Figure figure_moved_masks(const ShadowRow& row);

/// Figure 8: the scene, and what shadows its depth map would cast.
Figure figure_depth_shadows(const StillLife& scene);

/// Figure 9: shapes of the shadows in lights between.
Figure figure_shadow_shapes(const ShadowRow& row);

/// Figure 10: difference of the shadows halfway.
Figure figure_shadow_difference(const ShadowRow& row);

/// Figures 11 and 12: pictures in lights halfway between the captured ones; of figure 13 closeups.
Figure figure_light_between(const StillLife& scene, int number);

/// Figure 14: error maps of one such picture.
Figure figure_error_maps(const StillLife& scene);

}  // namespace sheen
