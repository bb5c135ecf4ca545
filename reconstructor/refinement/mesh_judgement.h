// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/refinement/left_out_gain.h"
#include "reconstructor/refinement/mesh_refinement.h"

namespace sheen {

/// How much better the refined mesh predicts the images that were left out, on the pixels of the given mesh's object.
LeftOutGain judge_mesh(const Mesh& given, const Mesh& refined, const RefinementImages& images, const LeftOut& split,
                       const StepsDone& progress = {});

/// A mesh that is refined against most of the images and judged by the rest: where they do not gain, or nothing can be
/// judged, the mesh stays as it was given.
struct JudgedMesh {
  RefinedMesh refined;  ///< before it was judged
  LeftOutGain judgement;
  LeftOut split;  ///< images that judged, and those that it was refined against
  bool kept_given() const { return !judgement.refined_is_better(); }
};
/// Where not all images are known to have masks, the mesh is refined with either of `UnmaskedOutlines`, and the better
/// one is kept. Throws Error where fewer than two images are left to refine it against.
JudgedMesh refine_and_judge(const Mesh& mesh, const RefinementImages& images, const StepsDone& progress = {});

}  // namespace sheen
