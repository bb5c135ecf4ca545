// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "reconstructor/models/surface_light_field/light_field_snapshot.h"

namespace sheen {

/// What one more image from each of these places (object frame) is worth to the light field, in arbitrary units; 0 =
/// nothing: the squared error that a picture from there is expected to have, by kriging. What a vertex looks like from
/// a direction is uncertain as far as its images so far, from theirs, do not tell (posterior variance, with one
/// covariance for all vertices), times how much the vertex varies with the view, and by how much one may be elsewhere
/// whose place is a guess; what no image shows is wrong by its colour, too. Summed over the surface in sight. Unlike
/// the paper's heuristic (000 sec. 3.3) it knows that two images near each other say little more than one, and how much
/// of the surface a place shows. Looks at a part of the vertices, so that it can be asked for several times per second.
std::vector<double> image_worth(const LightFieldSnapshot& snapshot, std::span<const Eigen::Vector3d> eyes);

}  // namespace sheen
