// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "common/base/progress.h"
#include "common/geometry/mesh.h"
#include "reconstructor/refinement/refinement_images.h"

namespace sheen {

struct RefinementPass {
  double spacing_px = 0;     ///< between the points of the patches, pixels
  std::size_t observed = 0;  ///< vertices that images or rims determine
  std::size_t moved = 0;     ///< vertices that moved at all
  double rms_move = 0;       ///< metres, over all vertices
  double agreement = 0;      ///< of the images, before the pass: mean correlation about the observed vertices
};

struct RefinedMesh {
  Mesh mesh;
  std::vector<float> moved;        ///< metres along the outward normal, per vertex
  std::vector<float> uncertainty;  ///< standard deviation along the normal, metres, per vertex
  std::vector<bool> observed;      ///< per vertex: whether any image determines it
  std::vector<RefinementPass> passes;
};

/// Where the outlines of images without a mask are.
enum class UnmaskedOutlines {
  kAsGiven,    ///< as the mesh has them, which was carved from them or scanned well
  kFromEdges,  ///< where the images have edges along them
};

/// Moves the vertices of a mesh along their normals to where the images agree best about the surface
/// (docs/decisions/refinement.md).
RefinedMesh refine_mesh(const Mesh& mesh, const RefinementImages& images,
                        UnmaskedOutlines outlines = UnmaskedOutlines::kAsGiven, const StepsDone& progress = {});

}  // namespace sheen
