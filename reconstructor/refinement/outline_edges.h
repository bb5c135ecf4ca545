// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "reconstructor/refinement/displacement_field.h"
#include "reconstructor/refinement/grey_pyramid.h"
#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {

/// Where outlines are that no mask shows. A vertex on the mesh's outline is tried at places along its normal: where it
/// really is, every image has an edge there, along the outline. Texture on either side of it has edges too, but from
/// each side at another place.
class OutlineEdges {
 public:
  static constexpr int kReach = 8;  ///< places to either side, half a patch spacing apart
  static constexpr int kPlaces = 2 * kReach + 1;

  /// `normals`: along which vertices move. `spacing`: of the patches, metres.
  OutlineEdges(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, std::span<const float> spacing);

  /// `scene`: of the mesh.
  void add(const GreyPyramid& image, const PosedCamera& view, const RayScene& scene);

  /// What they say of the displacements.
  Observations observe(const MeshEdges& edges) const;

 private:
  struct Sums {
    int images = 0;
    std::array<float, kPlaces> strength{};
  };
  const Mesh& mesh_;
  const std::vector<Eigen::Vector3f>& normals_;
  std::span<const float> spacing_;
  std::vector<Sums> sums_;
};

}  // namespace sheen
