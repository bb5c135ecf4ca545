// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/pose_judgement.h"

#include <numeric>
#include <utility>

#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"

namespace sheen {
namespace {

/// Tells of parts of a work, one after the other, as of one. A part is as long as images are read for it.
class ProgressOfParts {
 public:
  ProgressOfParts(std::vector<std::size_t> images, const StepsDone& progress)
      : images_(std::move(images)), progress_(progress) {}
  StepsDone part(std::size_t number) const {
    return [this, number](std::size_t done, std::size_t steps) {
      if (!progress_) return;
      const auto before =
          std::accumulate(images_.begin(), images_.begin() + static_cast<std::ptrdiff_t>(number), std::size_t{0});
      progress_(before + images_[number] * done / steps,
                std::accumulate(images_.begin(), images_.end(), std::size_t{0}));
    };
  }

 private:
  std::vector<std::size_t> images_;  ///< per part
  const StepsDone& progress_;
};

}  // namespace

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

  const std::size_t others = split.others.size(), left_out = split.left_out.size();
  const ProgressOfParts parts({others + all.size(), others + left_out, left_out}, progress);
  JudgedPoses judged{.refined = refine_poses(mesh, images, split.others, all, parts.part(0)), .judgement = {}};
  const std::vector<RefinedPose> fitted = refine_poses(mesh, images, split.others, split.left_out, parts.part(1));
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
  judged.judgement = mean_gain(split.left_out, gain, parts.part(2));
  return judged;
}

}  // namespace sheen
