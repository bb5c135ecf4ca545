// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/map_resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sheen {
namespace {

constexpr int kLargest = std::numeric_limits<std::uint8_t>::max();

}  // namespace

double pixels_per_metre(const Mesh& mesh, const Camera& camera, const Rigid3& camera_from_object) {
  const double distance = (camera_centre(camera_from_object) - bounding_sphere(mesh).centre).norm();
  return std::sqrt(camera.fx * camera.fy) / std::max(distance, 1e-9);
}

std::vector<std::uint8_t> map_resolution(const Mesh& mesh, const Camera& camera, const Rigid3& camera_from_object,
                                         const MapResolutionOptions& options) {
  if (options.fixed > 0)
    return std::vector<std::uint8_t>(
        mesh.triangles.size(),
        static_cast<std::uint8_t>(std::clamp<long>(std::lround(options.scale * options.fixed), 2, kLargest)));
  const double pixels = pixels_per_metre(mesh, camera, camera_from_object);
  std::vector<std::uint8_t> resolution(mesh.triangles.size());
  for (std::size_t t = 0; t < resolution.size(); ++t) {
    const Eigen::Vector3f a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    const double edge = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const int side = static_cast<int>(std::lround(options.scale * edge * pixels)) + 1;
    // A large triangle is not to blur: at most two pixels per sample.
    const int largest = std::min(std::max(options.largest, (side + 1) / 2), kLargest);
    resolution[t] = static_cast<std::uint8_t>(std::clamp(side, options.smallest, largest));
  }
  return resolution;
}

}  // namespace sheen
