// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/mesh.h"

namespace sheen {

struct MapResolutionOptions {
  int fixed = 0;                   ///< the same side for every triangle; 0 = from the footprint of a pixel
  int smallest = 4, largest = 24;  ///< bounds of the choice by footprint; but at least a sample for two pixels, to 255
  double scale = 1;                ///< of the side, fixed or chosen
};

/// Of an image from this camera, at its distance to the middle of the mesh.
double pixels_per_metre(const Mesh& mesh, const Camera& camera, const Rigid3& camera_from_object);

/// Side of each triangle's surface map: as many samples along its longest edge as it has pixels in an image from this
/// camera's distance to the mesh.
std::vector<std::uint8_t> map_resolution(const Mesh& mesh, const Camera& camera, const Rigid3& camera_from_object,
                                         const MapResolutionOptions& options);

}  // namespace sheen
