// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "reconstructor/refinement/left_out_gain.h"
#include "reconstructor/refinement/pose_refinement.h"

namespace sheen {

/// Poses that are refined against most of the images and judged by the rest.
struct JudgedPoses {
  std::vector<RefinedPose> refined;  ///< of all images, before they were judged
  LeftOutGain judgement;
  bool kept_given() const { return !judgement.refined_is_better(); }
};
/// The images that judge are predicted from the others in their given poses, and in their refined ones. A pose of an
/// image that judges may be off itself: in either case it is the one that fits best to what the others show.
/// `held_out`: images that neither judge nor are moved to, and are moved like those that judge.
JudgedPoses refine_and_judge_poses(const Mesh& mesh, const RefinementImages& images,
                                   const std::vector<std::size_t>& held_out, const StepsDone& progress = {});

}  // namespace sheen
