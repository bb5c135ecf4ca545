// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/surface_pictures.h"

#include <limits>

namespace sheen {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();

float depth_of(const Eigen::Vector3f& place, const PosedCamera& from) {
  return static_cast<float>((from.camera_from_object * place.cast<double>()).z());
}

/// Of the corners' values at a hit.
template <typename Corner>
Eigen::Vector3f between_corners(const Hit& hit, const Corner& corner) {
  return (1 - hit.u - hit.v) * corner(0) + hit.u * corner(1) + hit.v * corner(2);
}

}  // namespace

ImageF depth_picture(const Mesh& mesh, std::span<const Hit> hits, const PosedCamera& from) {
  ImageF depth(from.camera.width, from.camera.height, 1);
  for (std::size_t i = 0; i < hits.size(); ++i)
    depth.data()[i] =
        hits[i] ? depth_of(between_corners(hits[i], [&](int k) { return mesh.corner(hits[i].triangle, k); }), from)
                : kNoSurface;
  return depth;
}

ImageF depth_picture(const ImageF& places, const std::vector<bool>& known, const PosedCamera& from) {
  ImageF depth(places.width(), places.height(), 1);
  for (std::size_t i = 0; i < known.size(); ++i)
    depth.data()[i] = known[i] ? depth_of(Eigen::Vector3f::Map(places.data() + 3 * i), from) : kNoSurface;
  return depth;
}

ImageF normal_picture(const Mesh& mesh, std::span<const Eigen::Vector3f> vertex_normals, std::span<const Hit> hits,
                      const Camera& camera) {
  ImageF normals(camera.width, camera.height, 3);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i]) continue;
    const auto& triangle = mesh.triangles[hits[i].triangle];
    const Eigen::Vector3f normal =
        between_corners(hits[i], [&](int k) { return vertex_normals[triangle[static_cast<std::size_t>(k)]]; });
    Eigen::Vector3f::Map(normals.data() + 3 * i) = (hits[i].front ? 1 : -1) * normal.normalized();
  }
  return normals;
}

}  // namespace sheen
