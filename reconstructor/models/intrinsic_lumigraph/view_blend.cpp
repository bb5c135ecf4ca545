// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

#include <algorithm>
#include <cmath>

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
                     const std::function<RelitView(const LitView&)>& relit) {
  for (const WeightedView& near : views_near(data->views, eye)) {
    const auto& view = data->views[near.view];
    views_.push_back({view, near.weight, relit(*view)});
  }
  std::stable_sort(views_.begin(), views_.end(), [](const auto& a, const auto& b) { return a.weight > b.weight; });
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
