// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"

namespace sheen {

/// Distance along a camera's optical axis (z in its coordinates, metres) of what the rays through its pixels' centres
/// hit; infinite where that is nothing. `hits`: of the mesh, row by row.
ImageF depth_picture(const Mesh& mesh, std::span<const Hit> hits, const PosedCamera& from);

/// The same of a picture of places in the object frame, 3 channels; infinite where `known` is false.
ImageF depth_picture(const ImageF& places, const std::vector<bool>& known, const PosedCamera& from);

/// Unit normals of the surface that is seen, in the object frame, 3 channels: interpolated between those of the
/// vertices, and turned to the side that is seen; 0 where there is no surface.
ImageF normal_picture(const Mesh& mesh, std::span<const Eigen::Vector3f> vertex_normals, std::span<const Hit> hits,
                      const Camera& camera);

}  // namespace sheen
