// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "reconstructor/refinement/mesh_refinement.h"

namespace sheen {

inline constexpr double kWorthwhile_db = 0.1;  ///< less is what reflections and noise gain on a mesh that is right

/// How well images that were left out of a refinement are predicted from the others, by the mesh as it was given and as
/// it was refined.
struct MeshJudgement {
  std::size_t images = 0;     ///< that were left out
  double gain_db = 0;         ///< of the refined mesh, mean over them
  double standard_error = 0;  ///< of `gain_db`, dB
  /// A gain that is not chance and worth a change of the mesh.
  bool refined_is_better() const { return images > 0 && gain_db > std::max(standard_error, kWorthwhile_db); }
};

/// `left_out`, `others`: numbers of `images`. Each pixel of the given mesh's object is predicted from the four of the
/// others that look most alike and see the place (unstructured lumigraph, Buehler et al. 2001), in encoded luminance;
/// black where the mesh shows nothing of a mask; without one the pixel may be of the background, and what it is off by
/// is taken to lie between what right and wrong surfaces are off by.
MeshJudgement judge_mesh(const Mesh& given, const Mesh& refined, const RefinementImages& images,
                         const std::vector<std::size_t>& left_out, const std::vector<std::size_t>& others,
                         const StepsDone& progress = {});

/// A mesh that is refined against most of the images and judged by the rest: where they do not gain, or nothing can be
/// judged, the mesh stays as it was given.
struct JudgedMesh {
  RefinedMesh refined;  ///< before it was judged
  MeshJudgement judgement;
  std::vector<std::size_t> left_out, others;  ///< images that judged, and those that it was refined against
  bool kept_given() const { return !judgement.refined_is_better(); }
};
/// Every eighth image judges, of fewer than 32 every fourth. Where not all images are known to have masks, the mesh is
/// refined with either of `UnmaskedOutlines`, and the better one is kept. Throws Error where fewer than two are left.
JudgedMesh refine_and_judge(const Mesh& mesh, const RefinementImages& images, const StepsDone& progress = {});

}  // namespace sheen
