// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// What one more image from each of these places (object frame) is worth to the light field, in arbitrary units; 0 =
/// nothing. The paper's heuristic (000 sec. 3.3) says how badly a place is known; whether an image is worth taking also
/// depends on what else it tells. So two things are multiplied, both summed over the surface in sight, by how much a
/// ring varies with the view: how far the nearest image of each ring is from there, and how much nearer to an image the
/// surface would be as seen from all the places. The first alone strays to the rim, the second alone stays in the
/// middle. Looks at a part of the rings, so that it can be asked for several times a second.
std::vector<double> image_worth(const SurfaceLightFieldSnapshot& snapshot, std::span<const Eigen::Vector3d> eyes);

}  // namespace sheen
