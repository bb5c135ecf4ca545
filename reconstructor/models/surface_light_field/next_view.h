// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "reconstructor/models/surface_light_field/light_field_snapshot.h"

namespace sheen {

/// Where an image would be worth most (`CaptureGuidance::worth`): a place on the sphere through the present eye, above
/// the stage's plane. Where that place is well known already, the least known one. Looks at a part of the vertices, so
/// that it can be asked for several times per second.
ViewAdvice advise_next_view(const LightFieldSnapshot& snapshot, const Eigen::Vector3d& eye);

}  // namespace sheen
