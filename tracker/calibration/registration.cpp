// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/registration.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/format.h"

namespace sheen {
namespace {

constexpr double kOutlineOff_px = 2;       // median distance of outlines that do not belong together
constexpr double kHardlyAgree = 0.3;       // mean correlation of images that do not see what the mesh says
constexpr double kContradicts_sigmas = 5;  // per parameter, of points and images together

void judge_images(const ImageRegistration& found, bool free_scale, std::vector<std::string>& warnings) {
  if (found.evidence == Evidence::kOutlines && found.after > kOutlineOff_px)
    warnings.push_back(
        format("the outlines are still %.1f px apart (median): start from picked points (--points), or the "
               "mesh is not this object",
               found.after));
  if (found.evidence == Evidence::kTexture && found.after < kHardlyAgree)
    warnings.push_back(
        format("the images hardly agree about the surface (correlation %.2f): start from picked points "
               "(--points), give masks, or the mesh is not this object",
               found.after));
  if (found.undetermined > 0)
    warnings.push_back(
        format("%d of the %d parameters are not determined by the images: the object looks the same "
               "when it moves so; the mesh stays as it was in these",
               found.undetermined, free_scale ? 7 : 6));
}

/// Of points and images: the images' word for what they know, and a warning where the two cannot both be right.
void compare(const PointRegistration& points, const ImageRegistration& images, int parameters,
             std::vector<std::string>& warnings) {
  const PlacementStep step =
      step_between(points.placement.stage_from_mesh, images.placement.stage_from_mesh, points.placement.centre);
  const Eigen::MatrixXd both =
      (points.placement.covariance + images.placement.covariance).topLeftCorner(parameters, parameters);
  const Eigen::VectorXd off = step.head(parameters);
  if (std::sqrt(off.dot(both.ldlt().solve(off)) / parameters) > kContradicts_sigmas)
    warnings.push_back(
        format("the images move the mesh by %.2g mm and %.2g degrees from where the points have it, more "
               "than the two allow; look at the overlay",
               1e3 * step.segment<3>(3).norm(), step.head<3>().norm() / kDegree));
}

}  // namespace

Registration register_mesh(const Mesh& mesh, const Correspondences* picked,
                           const std::map<std::string, PosedCamera>& views, std::span<const RegistrationImage> images,
                           const RegistrationOptions& options, const StepsDone& progress) {
  Registration result{.free_scale = options.free_scale};
  result.placement.stage_from_mesh.scale = options.unit_m;
  if (picked) {
    result.points = register_points(*picked, mesh, views, {options.free_scale, options.unit_m});
    result.placement = result.points->placement;
    result.warnings = result.points->warnings;
  }
  const auto about_its_middle = [&](const Placement& placement) {
    return about(placement, placement.stage_from_mesh * bounding_sphere(mesh).centre);
  };
  result.placement = about_its_middle(result.placement);
  if (images.empty()) return result;
  result.images = register_to_images(mesh, images, result.placement.stage_from_mesh, options.free_scale, progress);
  judge_images(*result.images, options.free_scale, result.warnings);
  if (result.points) compare(*result.points, *result.images, options.free_scale ? 7 : 6, result.warnings);
  result.placement = about_its_middle(result.images->placement);
  return result;
}

Mesh placed(Mesh mesh, const Similarity& stage_from_mesh) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = (stage_from_mesh * vertex.cast<double>()).cast<float>();
  return mesh;
}

}  // namespace sheen
