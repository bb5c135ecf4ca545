// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>

#include "common/camera/rigid3.h"

namespace sheen {

// Directions towards a light as whoever looks at the picture has them: right, up, towards the eye. All are unit
// vectors. A small sphere shows them: the light is where it shines.

/// Object frame -> such a direction: its rows are right, up, towards the eye.
Eigen::Matrix3d picture_axes(const Rigid3& camera_from_object);

/// Turned so far to the right and up, radians, never behind the picture.
Eigen::Vector3d turned_light(const Eigen::Vector3d& light, double right, double up);

/// Where the light is when the sphere is pointed at there: right and up of its middle, in radii. Outside of the sphere:
/// at its rim.
Eigen::Vector3d light_at(const Eigen::Vector2d& place);

/// "Light from the upper left, 40 degrees off the picture".
std::string light_in_words(const Eigen::Vector3d& light);

}  // namespace sheen
