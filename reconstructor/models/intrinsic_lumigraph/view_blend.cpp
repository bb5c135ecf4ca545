// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/lumigraph_file/depth_points.h"
#include "reconstructor/lumigraph_file/four_pixels.h"

namespace sheen {

ViewBlend::ViewBlend(const std::shared_ptr<const LumigraphData>& data, const Eigen::Vector3d& eye, const Relight& relit)
    : eye_(eye.cast<float>()) {
  for (const WeightedView& near : data->of_images ? views_near(data->views, eye) : views_round(data->views, eye)) {
    const auto& view = data->views[near.view];
    const Rigid3& pose = view->from.camera_from_object;
    views_.push_back(
        {view, near.weight, relit(*view), pose.rotation.toRotationMatrix(), camera_centre(pose).cast<float>()});
  }
  std::stable_sort(views_.begin(), views_.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
}

std::optional<Eigen::Vector3f> ViewBlend::along(const Eigen::Vector3f& eye, const Eigen::Vector3f& guess) const {
  for (const Prepared& prepared : views_)
    if (const auto point = along(*prepared.view, eye, guess)) return point;
  return std::nullopt;
}

std::optional<Eigen::Vector3f> ViewBlend::along(const IntrinsicView& view, const Eigen::Vector3f& eye,
                                                const Eigen::Vector3f& guess) {
  constexpr int kSteps = 8;
  const DepthPoints surface(view.from);
  const Eigen::Vector3f direction = (guess - eye).normalized();
  Eigen::Vector3f point = guess;
  for (int step = 0; step < kSteps; ++step) {
    const auto pixel = view.from.camera.project(view.from.camera_from_object * point.cast<double>());
    if (!pixel || !view.from.camera.contains(*pixel, -0.5)) return std::nullopt;
    const int x = std::clamp(static_cast<int>(std::lround(pixel->x())), 0, view.depth.width() - 1),
              y = std::clamp(static_cast<int>(std::lround(pixel->y())), 0, view.depth.height() - 1);
    const Eigen::Vector3f seen = surface.at(pixel->x(), pixel->y(), view.depth.at(x, y));
    const float before = (point - eye).norm();
    point = eye + direction * direction.dot(seen - eye);
    if (std::abs((point - eye).norm() - before) < 1e-4f * before) break;
  }
  return point;
}

/// Of a view that sees a place more slantingly than the eye: its pixels are wide there. Or almost along the surface,
/// from elsewhere than the eye: they are mixed with what is behind the outline, and moved by what the mesh lacks.
float ViewBlend::slant_weight(const Eigen::Vector3f& point, const Eigen::Vector3f& facing,
                              const Eigen::Vector3f& from) const {
  constexpr float kSlanting = 0.3f, kElsewhere = 0.06f;  // cosine; 1 - cosine: 20 degrees
  if (facing.isZero()) return 1;
  const Eigen::Vector3f to_view = (from - point).normalized(), to_eye = (eye_ - point).normalized();
  const float cosine = facing.dot(to_view), here = facing.dot(to_eye);
  if (!(cosine > 0)) return 0;
  const float steep = std::min(1.0f, cosine / kSlanting),
              elsewhere = std::min(1.0f, (1 - to_view.dot(to_eye)) / kElsewhere);
  return (cosine < here ? cosine / here : 1) * (1 - elsewhere * (1 - steep));
}

std::optional<ViewBlend::Colours> ViewBlend::at(const Eigen::Vector3f& point, const Eigen::Vector3f& facing) const {
  Colours sum;
  std::optional<Colours> guess;
  for (const Prepared& prepared : views_) {
    const PosedCamera& from = prepared.view->from;
    const Eigen::Vector3d in_camera = prepared.rotation * point.cast<double>() + from.camera_from_object.translation;
    const auto pixel = from.camera.project(in_camera);
    if (!pixel || !from.camera.contains(*pixel, -0.5)) continue;
    const FourPixels near(prepared.view->depth, *pixel, in_camera.z());
    const float weight = near.seen() ? prepared.weight * slant_weight(point, facing, prepared.eye) : 0;
    const bool seen = weight > 0;
    if (!seen && guess) continue;
    const RelitView& relit = *prepared.relit;
    const Eigen::Vector3f lit = near.mean(relit.lit), dark = relit.dark.empty() ? lit : near.mean(relit.dark);
    if (!seen) {
      guess.emplace();
      guess->lit = lit;
      guess->dark = dark;
      continue;
    }
    sum.lit += weight * lit;
    sum.dark += weight * dark;
    sum.known += weight;
  }
  if (!(sum.known > 0)) return guess;
  sum.lit /= sum.known;
  sum.dark /= sum.known;
  return sum;
}

}  // namespace sheen
