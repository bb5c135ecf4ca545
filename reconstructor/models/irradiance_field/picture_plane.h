// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "common/image/image.h"

namespace sheen {

/// The rectangle that the camera sees, as two triangles: in the plane through the object's origin that faces it, or a
/// metre away where the origin is not before the camera. The camera has no distortion.
Mesh picture_plane(const PosedCamera& camera);

/// Pixel of the camera's image at barycentric (u, v) of a triangle of its picture plane.
Eigen::Vector2f picture_place(const ImageSize& size, std::uint32_t triangle, float u, float v);

}  // namespace sheen
