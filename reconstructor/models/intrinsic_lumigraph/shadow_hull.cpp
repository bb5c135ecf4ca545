// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/shadow_hull.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "reconstructor/models/intrinsic_lumigraph/depth_points.h"

namespace sheen {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr double kMostCells = 24e6;
constexpr float kPixelsPerCell = 1.2f;
constexpr double kOutliers = 0.002;  // of the points along each axis, on either side, that do not stretch the grid
constexpr float kBefore = 0.012f;    // of the depth: a cell this far before a camera's surface is looked through
// Ways of light through a cell, per view, that say that it is empty: a few are wrong at the edges of shadows.
constexpr double kCrossingsPerView = 0.5;
constexpr int kSpeck = 5;           // pixels: smaller spots of light or shadow are noise
constexpr float kClearance = 3.5f;  // cells: what a way to a lamp begins with, which is not asked

}  // namespace

ShadowHull::ShadowHull(std::span<const IntrinsicView* const> views, const LightSet& lights) {
  if (views.empty()) return;
  place_grid(views);
  look_through(views);
  const auto enough = static_cast<std::uint8_t>(
      std::clamp(std::ceil(kCrossingsPerView * static_cast<double>(views.size())), 2.0, 100.0));
  std::vector<std::uint8_t> crossings(cells_.size());
  for (const IntrinsicView* view : views) shine_through(*view, lights, enough, crossings);
  for (std::size_t i = 0; i < cells_.size(); ++i)
    if (crossings[i] >= enough) cells_[i] = 0;
}

ShadowHull::ShadowHull(const Vector3f& origin, float cell, const Vector3i& size, std::vector<std::uint8_t> cells)
    : origin_(origin), cell_(cell), size_(size), cells_(std::move(cells)) {}

template <typename Visit>
void ShadowHull::walk(const Vector3f& from, const Vector3f& direction, float length, const Visit& visit) const {
  // From cell to cell (Amanatides and Woo 1987).
  const Vector3f start = (from - origin_) / cell_, step = direction / cell_;
  Vector3i at = start.array().floor().cast<int>();
  Vector3f next, every;
  Vector3i side;
  for (int k = 0; k < 3; ++k) {
    side[k] = step[k] >= 0 ? 1 : -1;
    const float inverse = std::abs(step[k]) > 1e-12f ? 1 / std::abs(step[k]) : std::numeric_limits<float>::infinity();
    every[k] = inverse;
    const float inside = start[k] - static_cast<float>(at[k]);
    next[k] = std::isinf(inverse) ? inverse : (side[k] > 0 ? 1 - inside : inside) * inverse;
  }
  const std::size_t row = static_cast<std::size_t>(size_.x()), sheet = row * static_cast<std::size_t>(size_.y());
  for (float passed = 0; passed < length;) {
    if ((at.array() < 0).any() || (at.array() >= size_.array()).any()) return;
    if (!visit(static_cast<std::size_t>(at.x()) + row * static_cast<std::size_t>(at.y()) +
               sheet * static_cast<std::size_t>(at.z())))
      return;
    int axis = 0;
    passed = next.minCoeff(&axis);
    next[axis] += every[axis];
    at[axis] += side[axis];
  }
}

void ShadowHull::place_grid(std::span<const IntrinsicView* const> views) {
  std::array<std::vector<float>, 3> places;
  double footprint = 0;
  std::size_t points = 0;
  for (const IntrinsicView* view : views) {
    const DepthPoints surface(view->from);
    constexpr int kStride = 3;
    for (int y = 0; y < view->depth.height(); y += kStride)
      for (int x = 0; x < view->depth.width(); x += kStride) {
        const float depth = view->depth.at(x, y);
        if (!(depth > 0)) continue;
        const Vector3f point = surface.at(x, y, depth);
        for (std::size_t k = 0; k < 3; ++k) places[k].push_back(point[static_cast<Eigen::Index>(k)]);
        footprint += depth / view->from.camera.fx;
        ++points;
      }
  }
  if (points == 0) return;
  Vector3f low, high;
  for (std::size_t k = 0; k < 3; ++k) {
    std::sort(places[k].begin(), places[k].end());
    const auto cut = static_cast<std::size_t>(kOutliers * static_cast<double>(points));
    low[static_cast<Eigen::Index>(k)] = places[k][cut];
    high[static_cast<Eigen::Index>(k)] = places[k][points - 1 - cut];
  }
  cell_ = kPixelsPerCell * static_cast<float>(footprint / static_cast<double>(points));
  cell_ = std::max(cell_, static_cast<float>(std::cbrt(double((high - low).prod()) / kMostCells)));
  origin_ = low.array() - cell_;
  size_ = ((high - low) / cell_).array().ceil().cast<int>() + 2;
  cells_.assign(
      static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(size_.z()),
      1);
}

void ShadowHull::look_through(std::span<const IntrinsicView* const> views) {
  tbb::parallel_for(0, size_.z(), [&](int z) {
    std::size_t i =
        static_cast<std::size_t>(z) * static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(size_.x());
    for (int y = 0; y < size_.y(); ++y)
      for (int x = 0; x < size_.x(); ++x, ++i) {
        const Vector3f centre = origin_ + cell_ * (Vector3f(float(x), float(y), float(z)).array() + 0.5f).matrix();
        std::size_t in_view = 0, looked_through = 0;
        for (const IntrinsicView* view : views) {
          const Eigen::Vector3d in_camera = view->from.camera_from_object * centre.cast<double>();
          const auto pixel = view->from.camera.project(in_camera);
          if (!pixel || !view->from.camera.contains(*pixel)) continue;
          ++in_view;
          const float depth =
              view->depth.at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
          if (in_camera.z() < (1 - kBefore) * depth) ++looked_through;
        }
        if (looked_through > 0 || in_view == 0) cells_[i] = 0;
      }
  });
}

void ShadowHull::shine_through(const IntrinsicView& view, const LightSet& lights, std::uint8_t enough,
                               std::vector<std::uint8_t>& crossings) const {
  for (std::size_t l = 0; l < view.lights.size(); ++l) {
    const Lamp lamp = lights.lamp(view.lights[l]);
    for_each_point(view.from, view.depth, [&](std::size_t pixel, const Vector3f& point) {
      if (view.arrives[l].data()[pixel] != 255 || !(view.depth.data()[pixel] > 0)) return;
      const Vector3f towards = lamp.towards(point);
      const float length = towards.norm(), skip = kClearance * cell_ / length;
      walk(point + skip * towards, towards, lamp.kind == LightKind::kPoint ? 1 - skip : 1e30f, [&](std::size_t cell) {
        const std::atomic_ref<std::uint8_t> count(crossings[cell]);
        if (count.load(std::memory_order_relaxed) < enough) count.fetch_add(1, std::memory_order_relaxed);
        return true;
      });
    });
  }
}

bool ShadowHull::hides(const Vector3f& point, const Lamp& lamp) const {
  const Vector3f towards = lamp.towards(point);
  const float skip = kClearance * cell_ / towards.norm();
  bool hidden = false;
  walk(point + skip * towards, towards, lamp.kind == LightKind::kPoint ? 1 - skip : 1e30f, [&](std::size_t cell) {
    hidden = cells_[cell] != 0;
    return !hidden;
  });
  return hidden;
}

ImageU8 reached_past(const ShadowHull& hull, const IntrinsicView& view, const Lamp& lamp) {
  const int w = view.depth.width(), h = view.depth.height();
  ImageU8 sharp(w, h, 1, 255);
  for_each_point(view.from, view.depth, [&](std::size_t pixel, const Vector3f& point) {
    if (view.depth.data()[pixel] > 0 && hull.hides(point, lamp)) sharp.data()[pixel] = 0;
  });
  ImageU8 out(w, h, 1);
  const cv::Mat found(h, w, CV_8UC1, sharp.data());
  cv::Mat clean, smooth(h, w, CV_8UC1, out.data());
  cv::medianBlur(found, clean, kSpeck);
  cv::GaussianBlur(clean, smooth, {3, 3}, 0, 0, cv::BORDER_REPLICATE);
  return out;
}

}  // namespace sheen
