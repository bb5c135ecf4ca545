// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/refinement/displacement_field.h"

namespace sheen {

/// Pixels of a picture that show the front of a mesh: 255, else 0. Keeps the rays of the last camera.
class SilhouetteCaster {
 public:
  ImageU8 cast(const PosedCamera& view, const Mesh& mesh, const RayScene& scene);

 private:
  Camera rays_of_;
  std::vector<Eigen::Vector3f> rays_;  ///< camera frame; NaN where the lens has none
};

/// Distance of each pixel from the outline of a silhouette, pixels: positive inside, 0 half way between an inner and an
/// outer pixel.
ImageF distance_from_outline(const ImageU8& silhouette);

/// Where the mesh's outline in an image is not where the silhouette has it, the vertices on it must move: adds what the
/// image says of them. Vertices in front of another surface say nothing; nor do those further than `reach_px` from the
/// silhouette's outline, which then belongs to something else.
/// `normals`: along which vertices move. `sigma_px`: standard deviation of the silhouette's outline.
void observe_rims(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, const RayScene& scene,
                  const PosedCamera& view, const ImageF& from_outline, double sigma_px, double reach_px,
                  Observations& observed);

}  // namespace sheen
