// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"

namespace sheen {

// From the frame of the files into the same with its origin moved there (metres), where a mesh far from zero has its
// vertices (`Mesh::origin`); with the origin negated, back. All in double precision.

PosedCamera in_frame_at(const Eigen::Vector3d& origin, PosedCamera camera);
/// A point light is moved, others have no place.
LightState in_frame_at(const Eigen::Vector3d& origin, LightState light);
Capture in_frame_at(const Eigen::Vector3d& origin, Capture capture);

}  // namespace sheen
