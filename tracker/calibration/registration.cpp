// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/registration.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "common/registration/frame_mistakes.h"

namespace sheen {
namespace {

constexpr double kOutlineOff_px = 2;       // median distance of outlines that do not belong together
constexpr double kHardlyAgree = 0.3;       // mean correlation of images that do not see what the mesh says
constexpr double kContradicts_sigmas = 5;  // per parameter, of points and images together

/// Why the images do not show the mesh where it was moved to; empty where they do.
std::string why_not_found(const ImageRegistration& found) {
  if (found.evidence == Evidence::kOutlines && found.after > kOutlineOff_px)
    return format(
        "the outlines are still %.1f px apart (median): start from picked points (--points), or the "
        "mesh is not this object",
        found.after);
  if (found.evidence == Evidence::kTexture && found.after < kHardlyAgree)
    return format(
        "the images hardly agree about the surface (correlation %.2f): start from picked points "
        "(--points), give masks, or the mesh is not this object",
        found.after);
  return {};
}

std::string open_parameters(int undetermined, int parameters) {
  return format(
      "%d of the %d parameters are not determined by the images: the object looks the same when it moves so; "
      "the mesh stays as it was in these",
      undetermined, parameters);
}

/// Where to begin without points: where the mesh stands, or where it would but for a mistake of frames.
Similarity start_of(const Mesh& mesh, std::span<const RegistrationImage> images, const Similarity& as_it_is,
                    std::string& undone) {
  Mesh in_metres = mesh;
  for (Eigen::Vector3f& vertex : in_metres.vertices) vertex *= static_cast<float>(as_it_is.scale);
  const auto mistake = find_frame_mistake(in_metres, images);
  if (!mistake) return as_it_is;
  if (mistake->mirrored)
    throw Error("the images show the object mirrored, which no placement can do to a mesh: " + mistake->remedy);
  undone = mistake->remedy;
  Similarity start = mistake->poses_from_mesh;
  start.scale *= as_it_is.scale;
  return start;
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
  const Similarity start = picked ? result.placement.stage_from_mesh
                                  : start_of(mesh, images, result.placement.stage_from_mesh, result.undone);
  result.images = register_to_images(mesh, images, start, options.free_scale, progress);
  const int parameters = options.free_scale ? 7 : 6;
  result.not_found = why_not_found(*result.images);
  if (result.images->undetermined > 0)
    result.warnings.push_back(open_parameters(result.images->undetermined, parameters));
  if (result.points) compare(*result.points, *result.images, parameters, result.warnings);
  result.placement = about_its_middle(result.images->placement);
  return result;
}

Mesh placed(Mesh mesh, const Similarity& stage_from_mesh) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = (stage_from_mesh * vertex.cast<double>()).cast<float>();
  return mesh;
}

}  // namespace sheen
