// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/mesh.h"
#include "common/image/image.h"

namespace sheen {

/// The outlines of a mesh: edges at which the surface ends, or where one side of it faces the eye and the other does
/// not. Everything that a picture shows beside or before something else ends at one of them.
class Outlines {
 public:
  explicit Outlines(const Mesh& mesh);

  /// Pixels through which an outline runs, as the camera sees it through its lens; those that the surface hides count,
  /// too. 1 channel, of the camera's size: 255 or 0.
  ImageU8 pixels(const Camera& camera, const Rigid3& camera_from_object) const;

 private:
  struct Edge {
    std::array<std::uint32_t, 2> vertices;
    std::array<std::uint32_t, 2> triangles;  ///< the same one twice: an outline from everywhere
  };
  struct Plane {
    Eigen::Vector3f normal, point;
  };
  std::vector<Eigen::Vector3f> vertices_;
  std::vector<Plane> planes_;  ///< of the triangles
  std::vector<Edge> edges_;
};

}  // namespace sheen
