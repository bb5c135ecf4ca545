// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/pose_judgement.h"

#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"

namespace sheen {

JudgedPoses refine_and_judge_poses(const Mesh& mesh, const RefinementImages& images,
                                   const std::vector<std::size_t>& held_out, const StepsDone& progress) {
  std::vector<bool> is_held_out(images.cameras.size(), false);
  for (const std::size_t i : held_out) is_held_out[i] = true;
  std::vector<std::size_t> all, training;
  for (std::size_t i = 0; i < images.cameras.size(); ++i) {
    all.push_back(i);
    if (!is_held_out[i]) training.push_back(i);
  }
  LeftOut split = leave_out_some(training.size());
  for (std::vector<std::size_t>* part : {&split.left_out, &split.others})
    for (std::size_t& number : *part) number = training[number];

  // Each part of the work is as long as images are read for it.
  const std::size_t refine_all = split.others.size() + all.size(), fit = split.others.size() + split.left_out.size(),
                    judge = split.left_out.size();
  const auto part = [&](std::size_t before, std::size_t read) -> StepsDone {
    if (!progress) return {};
    return [&progress, before, read, total = refine_all + fit + judge](std::size_t done, std::size_t steps) {
      progress(before + read * done / steps, total);
    };
  };
  JudgedPoses judged{.refined = refine_poses(mesh, images, split.others, all, part(0, refine_all)), .judgement = {}};
  const std::vector<RefinedPose> fitted =
      refine_poses(mesh, images, split.others, split.left_out, part(refine_all, fit));
  const RayScene scene(mesh);
  const Eigen::Vector3d centre = bounding_sphere(mesh).centre;
  SilhouetteCaster caster;
  const auto gain = [&](std::size_t i) {
    const PosedCamera& view = images.cameras[i];
    const ImageF inside = distance_from_outline(caster.cast(view, mesh, scene));
    const std::vector<SourceImage> given = nearest_sources(images, view, centre, split.others);
    std::vector<SourceImage> moved;
    for (const SourceImage& source : given)
      moved.push_back(source.moved_to(judged.refined[source.number].camera_from_object));
    return gain_at(images.read(i), inside, {scene, {view.camera, fitted[i].camera_from_object}, given},
                   {scene, {view.camera, judged.refined[i].camera_from_object}, moved});
  };
  judged.judgement = mean_gain(split.left_out, gain, part(refine_all + fit, judge));
  return judged;
}

}  // namespace sheen
