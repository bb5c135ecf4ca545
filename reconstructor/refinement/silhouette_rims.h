// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "reconstructor/refinement/displacement_field.h"

namespace sheen {

/// Vertices where the mesh turns from facing the eye to facing away.
std::vector<bool> on_contour(const Mesh& mesh, const Eigen::Vector3f& eye);
/// Whether a ray from the eye beside such a vertex, a little further out, passes without meeting anything.
/// `focal`: pixels.
bool is_rim(const Eigen::Vector3f& vertex, const Eigen::Vector3f& normal, const Eigen::Vector3f& eye, double focal,
            const RayScene& scene);

/// Where the mesh's outline in an image is not where the silhouette has it, the vertices on it must move: adds what the
/// image says of them. Vertices in front of another surface say nothing; nor do those further than `reach_px` from the
/// silhouette's outline, which then belongs to something else.
/// `normals`: along which vertices move. `sigma_px`: standard deviation of the silhouette's outline.
void observe_rims(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, const RayScene& scene,
                  const PosedCamera& view, const ImageF& from_outline, double sigma_px, double reach_px,
                  Observations& observed);

}  // namespace sheen
