// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/mesh.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"

namespace sheen {

/// The paper's test (000 sec. 4.2), back-projection: per vertex, whether it falls into the image, on a pixel that is
/// not masked, and nothing lies between it and the camera. `scene`: of the mesh. `mask`: empty, or the image's size
/// with 0 where pixels are to be ignored. What is nearer to the camera than `nearer` of a vertex's distance hides it.
std::vector<std::uint8_t> visible_vertices(const Mesh& mesh, const RayScene& scene, const Camera& camera,
                                           const Rigid3& camera_from_object, const ImageU8& mask, float nearer);

}  // namespace sheen
