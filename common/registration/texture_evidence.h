// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/registration/placement_fit.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// Whether images agree about what is on the surface: points of the mesh must show the same detail in all images that
/// see them. The value that they should show is their mean, which follows the placement.
class TextureEvidence {
 public:
  /// All must outlive it. `finest`: level that it will be asked for.
  TextureEvidence(const Mesh& mesh, const RayScene& scene, std::span<const RegistrationImage> images, int finest = 0);

  /// The coarsest level on which the mesh is still several pixels wide.
  int coarsest(const Similarity& stage_from_mesh) const;

  /// Which image sees which point, from the placement; to be asked again when the mesh has moved. `margin_px`, of the
  /// level: how far points must lie inside the silhouette.
  void see(const Similarity& stage_from_mesh, int level, double margin_px);

  std::vector<ImageEquations> equations(const Similarity& stage_from_mesh, const Eigen::Vector3d& centre,
                                        Half half = Half::kBoth) const;

  /// Mean correlation of the images about the points that two or more see, -1 to 1; and how many those are.
  struct Agreement {
    double correlation = 0;
    std::size_t points = 0;
  };
  Agreement agreement(const Similarity& stage_from_mesh) const;

 private:
  struct Sight {
    std::uint32_t image;
    float weight;  ///< cosine between the view and the normal
  };
  const Mesh& mesh_;
  const RayScene& scene_;
  std::span<const RegistrationImage> images_;
  std::vector<DetailPyramid> pyramids_;
  std::vector<Eigen::Vector3f> points_, normals_;  ///< spread evenly over the surface, mesh frame
  std::vector<std::vector<Sight>> seen_;           ///< per point
  int level_ = 0;
};

}  // namespace sheen
