// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/carved_hull.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/depth_points.h"

namespace sheen {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr double kMostCells = 24e6, kMostWithBorder = 1.25 * kMostCells;
constexpr float kPixelsPerCell = 1.2f;
constexpr double kOutliers = 0.002;  // of the points along each axis, on either side, that do not stretch the grid
constexpr float kBefore = 0.016f;    // of the depth: a cell this far before a camera's surface is looked through
constexpr double kLookers = 0.12;    // of the cameras that a cell is before: one depth map alone may be wrong
// A cell is empty if, of the ways of a lamp's light through it, this part ends at pixels that are lit. Of about none
// that do the cell is solid: it casts a shadow, and the edge of that lies within the cells between.
constexpr float kEmptyPart = 0.4f;
constexpr std::uint16_t kLeastLit = 2, kMostWays = 60000;
constexpr std::uint8_t kLit = 220;     // of what arrives: from here on light has passed
constexpr std::uint8_t kShadow = 128;  // up to here it has not
constexpr float kLeastCosine = 0.3f;   // of light that is seen to arrive; what faces away is as bright as its shadow
constexpr float kLeastBright = 0.5f;   // of its surroundings: darker, a pixel may be in the shadow of all lamps
constexpr double kSurroundings = 0.1;  // of the picture's width

/// Pixels that are not much darker than what is round them. One that no lamp reaches looks like a dark one that all
/// reach; the light that seems to arrive there would pass through what hides it.
ImageU8 bright_pixels(const IntrinsicView& view) {
  const int w = view.depth.width(), h = view.depth.height();
  cv::Mat brightness(h, w, CV_32FC1);
  for (int i = 0; i < w * h; ++i) {
    const Eigen::half* rgb = view.reflectance.data() + 3 * i;
    brightness.at<float>(i / w, i % w) = float(rgb[0]) + float(rgb[1]) + float(rgb[2]);
  }
  constexpr double kMean = 64;  // of 255, so that what is four times as bright is as well told from it
  cv::Mat levels, around;
  brightness.convertTo(levels, CV_8U, kMean / std::max(1e-12, cv::mean(brightness)[0]));
  cv::medianBlur(levels, around, 2 * std::max(1, static_cast<int>(kSurroundings / 2 * w)) + 1);
  ImageU8 bright(w, h, 1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      bright.at(x, y) = levels.at<std::uint8_t>(y, x) >= kLeastBright * around.at<std::uint8_t>(y, x);
  return bright;
}

/// Cells of a grid round a box, with a border.
Eigen::Array3d sides_in_cells(const Eigen::Array3d& box, double cell) {
  return (box / cell).ceil() + 2;
}

/// The smallest side of a cell, from `least` on, at which the grid has no more of them than it may.
float cell_for(const Eigen::Array3d& box, double least) {
  constexpr double kCoarser = 1.1;
  double cell = std::max(least, std::cbrt(box.prod() / kMostCells));
  const auto too_many = [&](const Eigen::Array3d& sides) {  // a flat box is mostly border
    return !(sides.prod() <= kMostWithBorder && sides.maxCoeff() <= ShadowHull::kMostCellsOnASide);
  };
  while (too_many(sides_in_cells(box, cell))) cell *= kCoarser;
  return static_cast<float>(cell);
}

bool faces(const IntrinsicView& view, std::size_t pixel, const Vector3f& incidence) {
  const Vector3f slope =
      Eigen::Map<const Eigen::Matrix<Eigen::half, 3, 1>>(view.slope.data() + 3 * pixel).cast<float>();
  return slope.dot(incidence) >= kLeastCosine * slope.norm() * incidence.norm();
}

void count(std::uint16_t& ways) {
  const std::atomic_ref<std::uint16_t> shared(ways);
  if (shared.load(std::memory_order_relaxed) < kMostWays) shared.fetch_add(1, std::memory_order_relaxed);
}

/// A hull on its way: solid, then emptied of what cameras and light pass through.
class HullCarving {
 public:
  explicit HullCarving(std::span<const IntrinsicView* const> views) : views_(views) { place_grid(); }
  void look_through();
  void shine_through(const LightSet& lights);
  ShadowHull hull() && { return {origin_, cell_, size_, std::move(cells_)}; }

 private:
  /// How many ways of a lamp's light pass through each cell, and how many of them end at a pixel that is lit.
  struct LightWays {
    std::vector<std::uint16_t> all, lit;
    explicit LightWays(std::size_t cells) : all(cells), lit(cells) {}
  };
  void place_grid();
  void shine_through(const IntrinsicView& view, const ImageU8& bright, const LightSet& lights, int light,
                     LightWays& ways) const;
  /// Calls `visit(cell)` along the way until it leaves the grid.
  template <typename Visit>
  void walk(const Vector3f& from, const Vector3f& direction, float length, const Visit& visit) const;
  /// Along the way from a point to a lamp, but for where it begins: the surface itself.
  template <typename Visit>
  void walk_to_lamp(const Vector3f& point, const Lamp& lamp, const Visit& visit) const;

  std::span<const IntrinsicView* const> views_;
  Vector3f origin_ = Vector3f::Zero();
  float cell_ = 0;
  Vector3i size_ = Vector3i::Zero();
  std::vector<std::uint8_t> cells_;
};

template <typename Visit>
void HullCarving::walk(const Vector3f& from, const Vector3f& direction, float length, const Visit& visit) const {
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
    visit(static_cast<std::size_t>(at.x()) + row * static_cast<std::size_t>(at.y()) +
          sheet * static_cast<std::size_t>(at.z()));
    int axis = 0;
    passed = next.minCoeff(&axis);
    next[axis] += every[axis];
    at[axis] += side[axis];
  }
}

void HullCarving::place_grid() {
  std::array<std::vector<float>, 3> places;
  double footprint = 0;
  std::size_t points = 0;
  for (const IntrinsicView* view : views_) {
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
  const Eigen::Array3d box = (high - low).cast<double>().array();
  cell_ = cell_for(box, kPixelsPerCell * static_cast<float>(footprint / static_cast<double>(points)));
  origin_ = low.array() - cell_;
  size_ = ((high - low) / cell_).array().ceil().cast<int>() + 2;
  cells_.assign(
      static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(size_.z()),
      ShadowHull::kSolid);
}

void HullCarving::look_through() {
  tbb::parallel_for(0, size_.z(), [&](int z) {
    std::size_t i =
        static_cast<std::size_t>(z) * static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(size_.x());
    for (int y = 0; y < size_.y(); ++y)
      for (int x = 0; x < size_.x(); ++x, ++i) {
        const Vector3f centre = origin_ + cell_ * (Vector3f(float(x), float(y), float(z)).array() + 0.5f).matrix();
        std::size_t in_view = 0, looked_through = 0;
        for (const IntrinsicView* view : views_) {
          const Eigen::Vector3d in_camera = view->from.camera_from_object * centre.cast<double>();
          const auto pixel = view->from.camera.project(in_camera);
          if (!pixel || !view->from.camera.contains(*pixel)) continue;
          ++in_view;
          const float depth =
              view->depth.at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
          if (in_camera.z() < (1 - kBefore) * depth) ++looked_through;
        }
        if (static_cast<double>(looked_through) > kLookers * static_cast<double>(in_view) || in_view == 0)
          cells_[i] = 0;
      }
  });
}

void HullCarving::shine_through(const LightSet& lights) {
  std::vector<ImageU8> bright;
  for (const IntrinsicView* view : views_) bright.push_back(bright_pixels(*view));
  for (int light = 0; light < static_cast<int>(lights.places.cols()); ++light) {
    LightWays ways(cells_.size());
    for (std::size_t v = 0; v < views_.size(); ++v) shine_through(*views_[v], bright[v], lights, light, ways);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (ways.lit[i] < kLeastLit) continue;
      const float lit = static_cast<float>(ways.lit[i]) / static_cast<float>(ways.all[i]);
      cells_[i] =
          std::min(cells_[i], static_cast<std::uint8_t>(ShadowHull::kSolid * std::max(0.0f, 1 - lit / kEmptyPart)));
    }
  }
}

void HullCarving::shine_through(const IntrinsicView& view, const ImageU8& bright, const LightSet& lights, int light,
                                LightWays& ways) const {
  const auto found = std::find(view.lights.begin(), view.lights.end(), light);
  if (found == view.lights.end()) return;
  const ImageU8& arrives = view.arrives[static_cast<std::size_t>(found - view.lights.begin())];
  const Lamp lamp = lights.lamp(light);
  for_each_point(view.from, view.depth, in_parallel, [&](std::size_t pixel, const Vector3f& point) {
    const bool lit = arrives.data()[pixel] >= kLit;
    if (!(view.depth.data()[pixel] > 0) || (!lit && arrives.data()[pixel] > kShadow)) return;
    if (lit && !(bright.data()[pixel] && faces(view, pixel, lamp.incidence(point)))) return;
    walk_to_lamp(point, lamp, [&](std::size_t cell) {
      count(ways.all[cell]);
      if (lit) count(ways.lit[cell]);
    });
  });
}

template <typename Visit>
void HullCarving::walk_to_lamp(const Vector3f& point, const Lamp& lamp, const Visit& visit) const {
  const Vector3f towards = lamp.towards(point);
  const float skip = kHullClearance * cell_ / towards.norm();
  walk(point + skip * towards, towards, lamp.kind == LightKind::kPoint ? 1 - skip : 1e30f, visit);
}

}  // namespace

ShadowHull carved_hull(std::span<const IntrinsicView* const> views, const LightSet& lights) {
  if (views.empty()) return {};
  HullCarving carving(views);
  carving.look_through();
  carving.shine_through(lights);
  return std::move(carving).hull();
}

}  // namespace sheen
