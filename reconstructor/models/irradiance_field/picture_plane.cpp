// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/picture_plane.h"

#include <array>
#include <vector>

namespace sheen {
namespace {

constexpr std::array<std::array<int, 3>, 2> kTriangles{{{0, 3, 2}, {0, 2, 1}}};  // seen by the camera from the front

/// Top left, top right, bottom right, bottom left: the outer edges of the pixels there.
std::array<Eigen::Vector2d, 4> picture_corners(const ImageSize& size) {
  const double right = size.width - 0.5, bottom = size.height - 0.5;
  return {{{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}}};
}

}  // namespace

Mesh picture_plane(const PosedCamera& camera) {
  const double depth = camera.camera_from_object.translation.z() > 0 ? camera.camera_from_object.translation.z() : 1;
  const Rigid3 object_from_camera = camera.camera_from_object.inverse();
  std::vector<Eigen::Vector3d> corners;
  for (const Eigen::Vector2d& corner : picture_corners({camera.camera.width, camera.camera.height})) {
    const Eigen::Vector3d point((corner.x() - camera.camera.cx) / camera.camera.fx,
                                (corner.y() - camera.camera.cy) / camera.camera.fy, 1);
    corners.push_back(object_from_camera * (depth * point));
  }
  std::vector<Triangle> triangles;
  for (const auto& [a, b, c] : kTriangles)
    triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), static_cast<std::uint32_t>(c)});
  return mesh_of(corners, std::move(triangles));
}

Eigen::Vector2f picture_place(const ImageSize& size, std::uint32_t triangle, float u, float v) {
  const auto corners = picture_corners(size);
  const auto corner = [&](std::size_t c) { return corners[static_cast<std::size_t>(kTriangles[triangle][c])]; };
  return ((1.0 - u - v) * corner(0) + u * corner(1) + v * corner(2)).cast<float>();
}

}  // namespace sheen
