// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstructor/models/intrinsic_lumigraph/depth_points.h"

namespace sheen {
namespace {

constexpr double kSameDepth = 0.01;  // of the depth: a point is what a view shows there

/// The four pixels round a place of an image, those of the border where it is beside it, and their bilinear weights:
/// found once for all images of a view.
class FourPixels {
 public:
  FourPixels(const ImageF& image, const Eigen::Vector2d& place) {
    const auto left = static_cast<int>(std::floor(place.x())), top = static_cast<int>(std::floor(place.y()));
    const auto u = static_cast<float>(place.x() - left), v = static_cast<float>(place.y() - top);
    const int x0 = std::clamp(left, 0, image.width() - 1), x1 = std::clamp(left + 1, 0, image.width() - 1);
    const std::size_t y0 = row(image, top), y1 = row(image, top + 1);
    pixels_ = {y0 + x0, y0 + x1, y1 + x0, y1 + x1};
    weights_ = {(1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u};
  }

  /// Whether one of them shows a surface at this depth.
  bool show(const ImageF& depth, double z) const {
    return std::any_of(pixels_.begin(), pixels_.end(), [&](std::size_t pixel) {
      return std::abs(static_cast<double>(depth.data()[pixel]) - z) <= kSameDepth * z;
    });
  }
  Eigen::Vector3f mean(const ImageF& rgb) const {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < pixels_.size(); ++k)
      sum += weights_[k] * Eigen::Vector3f::Map(rgb.data() + 3 * pixels_[k]);
    return sum;
  }

 private:
  static std::size_t row(const ImageF& image, int y) {
    return static_cast<std::size_t>(std::clamp(y, 0, image.height() - 1)) * image.width();
  }

  std::array<std::size_t, 4> pixels_;
  std::array<float, 4> weights_;
};

}  // namespace

ViewBlend::ViewBlend(const std::shared_ptr<const LumigraphData>& data, const Eigen::Vector3d& eye,
                     const Relight& relit) {
  for (const WeightedView& near : views_near(data->views, eye)) {
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

ViewBlend::Colours ViewBlend::at(const Eigen::Vector3f& point, const Eigen::Vector3f& facing) const {
  Colours sum, guess;
  float weights = 0;
  bool guessed = false;
  for (const Prepared& prepared : views_) {
    const PosedCamera& from = prepared.view->from;
    const Eigen::Vector3d in_camera = prepared.rotation * point.cast<double>() + from.camera_from_object.translation;
    const auto pixel = from.camera.project(in_camera);
    if (!pixel || !from.camera.contains(*pixel, -0.5)) continue;
    const FourPixels near(prepared.view->depth, *pixel);
    const bool seen = near.show(prepared.view->depth, in_camera.z()) && facing.dot(prepared.eye - point) >= 0;
    if (!seen && guessed) continue;
    const RelitView& relit = *prepared.relit;
    const Eigen::Vector3f lit = near.mean(relit.lit), dark = relit.dark.empty() ? lit : near.mean(relit.dark);
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
