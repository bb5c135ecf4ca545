// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/light_field_file/compact_model.h"
#include "reconstructor/light_field_file/encode/canonical_mesh.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// The same light field with one basis for so many neighbouring triangles, over the mesh in its stored order. What a
/// triangle's patch in the snapshot says of it in an image is part of a column; the basis holds what is *displayed* of
/// all columns: a term is kept while it adds `least_rms` grey levels or more to the picture of its triangle (RMS over
/// the views at its vertices as they are interpolated). A triangle whose vertices no image showed has the colour of the
/// nearest that one did
/// (`fill_unseen`).
CompactModel fit_patches(const SurfaceLightFieldSnapshot& snapshot, const CanonicalMesh& canonical, double least_rms,
                         std::size_t patch_triangles);

}  // namespace sheen
