// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/intrinsic_lumigraph/depth_points.h"

namespace sheen {
namespace {

constexpr double kSameDepth = 0.01;  // of the depth: a point is what a view shows there

/// Whether one of the four pixels round a place shows a surface at this depth.
bool shows(const ImageF& depth, const Eigen::Vector2d& pixel, double z) {
  const int x = static_cast<int>(std::floor(pixel.x())), y = static_cast<int>(std::floor(pixel.y()));
  for (int dy = 0; dy <= 1; ++dy)
    for (int dx = 0; dx <= 1; ++dx) {
      const double there =
          depth.at(std::clamp(x + dx, 0, depth.width() - 1), std::clamp(y + dy, 0, depth.height() - 1));
      if (std::abs(there - z) <= kSameDepth * z) return true;
    }
  return false;
}

}  // namespace

ViewBlend::ViewBlend(const std::shared_ptr<const LumigraphData>& data, const Eigen::Vector3d& eye,
                     const std::function<RelitView(const IntrinsicView&)>& relit) {
  for (const WeightedView& near : views_near(data->views, eye)) {
    const auto& view = data->views[near.view];
    views_.push_back({view, near.weight, relit(*view)});
  }
  std::stable_sort(views_.begin(), views_.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
}

std::optional<Eigen::Vector3f> ViewBlend::along(const Eigen::Vector3f& eye, const Eigen::Vector3f& guess) const {
  constexpr int kSteps = 8;
  if (views_.empty()) return std::nullopt;
  const IntrinsicView& view = *views_.front().view;
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

ViewBlend::Colours ViewBlend::at(const Eigen::Vector3f& point) const {
  Colours sum, guess;
  float weights = 0;
  bool guessed = false;
  for (const Prepared& prepared : views_) {
    const PosedCamera& from = prepared.view->from;
    const Eigen::Vector3d in_camera = from.camera_from_object * point.cast<double>();
    const auto pixel = from.camera.project(in_camera);
    if (!pixel || !from.camera.contains(*pixel, -0.5)) continue;
    const bool seen = shows(prepared.view->depth, *pixel, in_camera.z());
    if (!seen && guessed) continue;
    const RelitView& relit = prepared.relit;
    const Eigen::Vector3f lit = sample_rgb(relit.lit, *pixel),
                          dark = relit.dark.empty() ? lit : sample_rgb(relit.dark, *pixel);
    if (!seen) {
      guess = {lit, dark, false};
      guessed = true;
      continue;
    }
    sum.lit += prepared.weight * lit;
    sum.dark += prepared.weight * dark;
    weights += prepared.weight;
  }
  if (!(weights > 0)) return guess;
  return {sum.lit / weights, sum.dark / weights, true};
}

}  // namespace sheen
