// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_judgement.h"

#include <optional>
#include <utility>

#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"

namespace sheen {

LeftOutGain judge_mesh(const Mesh& given, const Mesh& refined, const RefinementImages& images, const LeftOut& split,
                       const StepsDone& progress) {
  const RayScene given_scene(given), refined_scene(refined);
  const Eigen::Vector3d centre = bounding_sphere(given).centre;
  SilhouetteCaster caster;
  const auto gain = [&](std::size_t i) {
    const PosedCamera& view = images.cameras[i];
    const ImageF inside = distance_from_outline(caster.cast(view, given, given_scene));
    const std::vector<SourceImage> sources = nearest_sources(images, view, centre, split.others);
    return gain_at(images.read(i), inside, {given_scene, view, sources}, {refined_scene, view, sources});
  };
  return mean_gain(split.left_out, gain, progress);
}

JudgedMesh refine_and_judge(const Mesh& mesh, const RefinementImages& images, const StepsDone& progress) {
  const LeftOut split = leave_out_some(images.cameras.size());
  const RefinementImages fitted = images.some(split.others);
  std::vector<UnmaskedOutlines> ways{UnmaskedOutlines::kAsGiven};
  if (!images.masked) ways.push_back(UnmaskedOutlines::kFromEdges);
  std::optional<JudgedMesh> best;
  for (std::size_t way = 0; way < ways.size(); ++way) {
    std::size_t steps_of_one = 0;
    const StepsDone part_done = [&](std::size_t done, std::size_t steps) {
      steps_of_one = steps;
      if (progress) progress(way * steps + done, ways.size() * steps);
    };
    const StepsDone judging = [&](std::size_t, std::size_t) { part_done(steps_of_one, steps_of_one); };
    JudgedMesh judged{.refined = refine_mesh(mesh, fitted, ways[way], part_done), .judgement = {}, .split = split};
    judged.judgement = judge_mesh(mesh, judged.refined.mesh, images, split, judging);
    if (!best || judged.judgement.gain_db > best->judgement.gain_db) best = std::move(judged);
  }
  return *std::move(best);
}

}  // namespace sheen
