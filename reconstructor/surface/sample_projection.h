// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/geometry/mesh.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// Where the samples of a mesh's triangles fall in an image. Calculated for each triangle that is asked for: for all
/// samples of a mesh it would be more to keep than the image itself.
class SampleProjection {
 public:
  /// Keeps both, which must outlive it.
  SampleProjection(const Mesh& mesh, const MapLayout& maps);
  void use(const MapLayout& maps);  ///< others, which it keeps too

  void use(const Camera& camera, const Rigid3& camera_from_object);

  /// Of the samples of a triangle, in their order.
  struct Places {
    std::span<const float> x, y;  ///< pixels, through the lens; NaN where it shows nothing
    std::span<const float> z;     ///< in the camera's frame
  };
  /// Theirs until the same thread asks again, of whichever projection.
  Places of(std::size_t triangle) const;

 private:
  /// Barycentric weights of corners 1 and 2, per lattice point.
  struct Lattice {
    std::vector<float> u, v;
  };

  const Mesh& mesh_;
  const MapLayout* maps_ = nullptr;
  std::array<Lattice, 256> lattices_;  ///< of the resolutions that triangles have
  Camera camera_;
  Rigid3 camera_from_object_;
};

}  // namespace sheen
