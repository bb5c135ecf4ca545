// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/progress.h"
#include "common/camera/rigid3.h"
#include "common/geometry/mesh.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

struct RefinedPose {
  Rigid3 camera_from_object;
  double moved_px = 0;        ///< of the surface that it sees, root of the mean square
  double uncertainty_px = 0;  ///< standard deviation of the same
  std::size_t patches = 0;    ///< that it rests on; 0: it stays as it was given
};

/// Moves poses to where each image shows of a mesh what the others show (docs/decisions/refinement.md): those of the
/// `movers`, to the images of the `leaders` (two or more), numbers of `images`. An image that is both is moved to what
/// the other leaders show. One for each image; the others' are as given.
std::vector<RefinedPose> refine_poses(const Mesh& mesh, const RefinementImages& images,
                                      const std::vector<std::size_t>& leaders, const std::vector<std::size_t>& movers,
                                      const StepsDone& progress = {});

}  // namespace sheen
