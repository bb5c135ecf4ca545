// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/progress.h"
#include "common/geometry/mesh.h"
#include "common/registration/placement.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// What images say about where a mesh stands.
enum class Evidence : std::uint8_t {
  kOutlines,  ///< the mesh's outlines against those of masks
  kTexture,   ///< the images' agreement about the detail on the surface
};
const char* to_string(Evidence evidence);

struct ImageRegistration {
  Evidence evidence = Evidence::kTexture;
  Placement placement;
  std::size_t images = 0;  ///< that say anything
  /// kOutlines: median distance of the outlines, pixels. kTexture: mean correlation of the images about the surface.
  double before = 0, after = 0;
  /// Placement of the odd images less that of the even ones, and its size in standard deviations (root of the mean
  /// square over the parameters). The covariance is already multiplied by its square where that is more than 1.
  PlacementStep halves = PlacementStep::Zero();
  double halves_sigmas = 0;
  int undetermined = 0;  ///< directions in which the images leave the mesh free
};

/// Moves a mesh from `start` to where the images show it: by outlines where there are masks of the object, else by
/// texture, from coarse to fine. Throws Error when the images say nothing of it.
ImageRegistration register_to_images(const Mesh& mesh, std::span<const RegistrationImage> images,
                                     const Similarity& start, bool free_scale, const StepsDone& progress = {});

}  // namespace sheen
