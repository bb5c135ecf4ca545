// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/patch_view.h"

#include <cmath>

namespace sheen {
namespace {

constexpr float kRimMargin = 1.5f;  // patches by which what surrounds one must be seen, too: silhouettes are no texture
constexpr float kContrastFloor = 0.012f;  // standard deviation of grey, of 1: three levels of 255 are noise

/// Whether the ray to a point of a patch meets the surface near it: nothing hides it, and it lies within the
/// silhouette.
bool meets_surface(const RayScene& scene, const Eigen::Vector3f& point, const Eigen::Vector3f& eye, float clearance) {
  const Eigen::Vector3f direction = (point - eye).normalized();
  const Hit hit = scene.intersect(Ray{eye, direction});
  return hit && hit.front && std::abs(hit.distance - (point - eye).norm()) < clearance;
}

}  // namespace

std::optional<Patch> PatchView::sample(const GreyPyramid& image, const Eigen::Vector2f& at) const {
  Patch patch;
  for (int s = 0; s < kPatchPoints; ++s) patch[s] = image.sample(level, at.x() + offsets(0, s), at.y() + offsets(1, s));
  const float mean = patch.mean();
  if (!std::isfinite(mean)) return {};
  patch -= mean;
  const float variance = patch.square().mean();
  patch /= std::sqrt(kPatchPoints * (variance + kContrastFloor * kContrastFloor));
  return patch;
}

std::optional<PatchView> view_patch(const PosedCamera& view, const Eigen::Vector3f& vertex,
                                    const VertexPatches& patches, std::size_t number, const GreyPyramid& image,
                                    const RayScene& scene, float clearance) {
  const Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();
  const float spacing = patches.spacing[number];
  PatchView seen;
  seen.cosine = patches.normals[number].dot((eye - vertex).normalized());
  if (seen.cosine < kLeastCosine) return {};
  const auto project = [&](const Eigen::Vector3f& point) {
    return view.camera.project(view.camera_from_object * point.cast<double>());
  };
  const auto middle = project(vertex);
  if (!middle) return {};
  seen.pixel = middle->cast<float>();
  for (int axis = 0; axis < 3; ++axis) {
    const auto pixel = project(vertex + spacing * Eigen::Vector3f::Unit(axis));
    if (!pixel) return {};
    seen.pixel_from_offset.col(axis) = (pixel->cast<float>() - seen.pixel) / spacing;
  }
  const auto offsets = patches.of(number);
  for (const int probe : kPatchProbes)
    if (!meets_surface(scene, vertex + kRimMargin * offsets[probe], eye, clearance * spacing / seen.cosine)) return {};
  seen.offsets =
      seen.pixel_from_offset * Eigen::Map<const Eigen::Matrix<float, 3, kPatchPoints>>(offsets.front().data());
  const float step_px = std::sqrt((seen.offsets.col(kPatchSide - 1) - seen.offsets.col(0)).norm() *
                                  (seen.offsets.col(kPatchPoints - kPatchSide) - seen.offsets.col(0)).norm()) /
                        (kPatchSide - 1);
  seen.level = image.level_for(step_px);
  return seen;
}

}  // namespace sheen
