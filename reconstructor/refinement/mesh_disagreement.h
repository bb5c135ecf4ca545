// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "common/geometry/mesh.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

/// How far the surface that images show is from where a mesh has it.
struct MeshDisagreement {
  std::size_t looked_at = 0;  ///< vertices
  std::size_t seen = 0;       ///< of these: four images or more look at them
  std::size_t observed = 0;   ///< of these: the images agree about where they are
  double off_px = 0;          ///< RMS along the normals, in pixels that look straight at the surface
  double gain_db = 0;         ///< by how much less images differ about the surface where others find it
};

/// A quick look at some vertices and images, one sweep of seven that refining takes. Each half of the images is judged
/// by the other: `off_px` is what the two have in common, `gain_db` what one's answer is worth to the other. The noise
/// of either, and a displacement that no image can tell from none, are no disagreement.
MeshDisagreement measure_disagreement(const Mesh& mesh, const RefinementImages& images, const StepsDone& progress = {});

}  // namespace sheen
