// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "common/camera/posed_camera.h"
#include "common/geometry/ray_scene.h"
#include "reconstructor/refinement/grey_pyramid.h"
#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {

/// What an image shows of a patch, point by point.
using Patch = Eigen::Array<float, kPatchPoints, 1>;

inline constexpr float kLeastCosine = 0.3f;  ///< of a view with a normal: flatter patches show little, hidden early

/// How a view sees a vertex's patch.
struct PatchView {
  float cosine = 0;                               ///< of the view with the normal
  Eigen::Vector2f pixel;                          ///< where the vertex falls
  Eigen::Matrix<float, 2, 3> pixel_from_offset;   ///< how pixels change with the point, pixels per metre
  Eigen::Matrix<float, 2, kPatchPoints> offsets;  ///< of the points from `pixel`, pixels
  int level = 0;  ///< of the pyramid, on which its points neither skip nor repeat detail

  /// The patch with its vertex at a pixel, less its mean, over its contrast: its norm is below 1, and small where it
  /// shows noise only. Empty where a point is not to be used.
  std::optional<Patch> sample(const GreyPyramid& image, const Eigen::Vector2f& at) const;
};

/// Empty where the view is too flat, and where a ray to the patch or to a margin round it does not meet the surface at
/// it: something hides it, or an outline crosses it. `clearance`: patch spacings by which the surface may be off where
/// it is met. `scene`: of the mesh whose vertex it is.
std::optional<PatchView> view_patch(const PosedCamera& view, const Eigen::Vector3f& vertex,
                                    const VertexPatches& patches, std::size_t number, const GreyPyramid& image,
                                    const RayScene& scene, float clearance);

}  // namespace sheen
