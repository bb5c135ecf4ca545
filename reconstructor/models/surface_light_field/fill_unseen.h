// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// The snapshot with a guess where no image showed the surface, for pictures that must have no holes: a sample takes
/// the mean colour of its ring's seen samples, with the ring's view dependence; a ring that no image reached takes
/// those of the nearest ring along the mesh. What was not seen stays marked as such (`RingSnapshot::measured`).
std::shared_ptr<const SurfaceLightFieldSnapshot> fill_unseen(const SurfaceLightFieldSnapshot& snapshot);

}  // namespace sheen
