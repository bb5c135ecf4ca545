// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// Gives basis rows to the samples of a patch that no image showed, so that nothing that is interpolated between seen
/// and unseen samples goes dark: beside seen samples the mean of these, farther off the patch's mean, per channel.
/// `resolution`: of the patch's triangles, in its order. `shown` stays.
void fill_unseen_samples(SurfacePatch& patch, std::span<const int> resolution);

/// The snapshot with a guess for the patches that no image reached, for pictures that must have no holes: at each of
/// its vertices such a patch takes the mean colour, with its view dependence, of the nearest patch along the mesh, also
/// where its triangles meet at several vertices of one place (a texture's seam). A part of the mesh that touches
/// nothing seen takes that of the nearest in space. What was not seen stays marked as such (`SurfacePatch::shown`).
std::shared_ptr<const SurfaceLightFieldSnapshot> fill_unseen(const SurfaceLightFieldSnapshot& snapshot);

}  // namespace sheen
