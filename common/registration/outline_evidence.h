// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/registration/placement_fit.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// Edges of a mesh and the triangles on either side.
struct EdgeOfMesh {
  std::uint32_t from = 0, to = 0;
  std::uint32_t left = 0, right = kNoHit;  ///< triangles; no right one at a border
};
std::vector<EdgeOfMesh> edges_of(const Mesh& mesh);

/// A piece of a mesh's outline in an image: from behind it nothing of the mesh stands out.
struct OutlinePoint {
  Eigen::Vector3f point;  ///< mesh frame
  Eigen::Vector2d pixel;
};
/// The outline as a camera in the mesh's frame sees it, two pixels apart or less where edges are longer.
std::vector<OutlinePoint> outline_of(const Mesh& mesh, std::span<const EdgeOfMesh> edges, const RayScene& scene,
                                     const PosedCamera& camera_from_mesh);

/// How far the mesh's outlines are from those of the masks. Images whose mask shows much more than an object of this
/// size are left out: such a mask says what may be looked at.
class OutlineEvidence {
 public:
  /// All must outlive it.
  OutlineEvidence(const Mesh& mesh, const RayScene& scene, std::span<const RegistrationImage> images,
                  const Similarity& start);

  bool any() const { return masks_ > 0; }
  std::size_t masks() const { return masks_; }
  /// `loss_px`: distances beyond it lose their weight (Cauchy).
  std::vector<ImageEquations> equations(const Similarity& stage_from_mesh, const Eigen::Vector3d& centre,
                                        double loss_px, Half half = Half::kBoth) const;
  /// Distances of the outline from the masks', pixels, of all images together.
  std::vector<double> distances(const Similarity& stage_from_mesh) const;

 private:
  const Mesh& mesh_;
  const RayScene& scene_;
  std::span<const RegistrationImage> images_;
  std::vector<EdgeOfMesh> edges_;
  std::vector<ImageF> from_outline_;  ///< per image; empty where its mask says nothing
  std::size_t masks_ = 0;
};

}  // namespace sheen
