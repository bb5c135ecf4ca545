// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/outline_fit.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/closed_surface.h"
#include "reconstructor/shape/object_hull.h"
#include "reconstructor/shape/silhouette.h"

namespace sheen {
namespace {

constexpr double kRays = 12'000;  // per view, about, for an overlap

bool is(const ShapeView& view, int x, int y, Outline mark) {
  return view.outline.at(x, y) == static_cast<std::uint8_t>(mark);
}

double overlap(const ShapeView& view, const Silhouette& silhouette) {
  const int width = view.outline.width(), height = view.outline.height();
  const int step = std::max(1, static_cast<int>(std::lround(std::sqrt(double(width) * height / kRays))));
  double both = 0, either = 0;
  for (int y = step / 2; y < height; y += step)
    for (int x = step / 2; x < width; x += step) {
      const bool hit = silhouette.has(x, y), object = !is(view, x, y, Outline::kBackground);
      both += hit && object ? 1 : 0;
      either += hit || object ? 1 : 0;
    }
  return either > 0 ? both / either : 0;
}

/// Of the object's pixels: in thin parts, such as a handle of wire, that the mesh has not. A frayed outline has none: a
/// part stands off what remains when all that is thin is taken away.
double thin_missing(const ShapeView& view, const Silhouette& silhouette, double thin_px) {
  const int width = view.outline.width(), height = view.outline.height();
  cv::Mat object(height, width, CV_8U), thick, off;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) object.at<std::uint8_t>(y, x) = is(view, x, y, Outline::kObject) ? 255 : 0;
  const int side = 2 * static_cast<int>(std::ceil(thin_px / 2)) + 1;
  cv::morphologyEx(object, thick, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  const int pixels = cv::countNonZero(object);
  if (cv::countNonZero(thick) == 0) return 0;
  cv::bitwise_not(thick, thick);
  cv::distanceTransform(thick, off, cv::DIST_L2, cv::DIST_MASK_5, CV_32F);
  int missing = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (object.at<std::uint8_t>(y, x) != 0 && off.at<float>(y, x) > static_cast<float>(side)) {
        if (!silhouette.has(x, y)) ++missing;
      }
  return static_cast<double>(missing) / pixels;
}

std::vector<double> overlaps_with(std::span<const ShapeView> views, const Mesh& mesh) {
  std::vector<double> overlaps(views.size(), 0);
  if (mesh.triangles.empty()) return overlaps;
  const RayScene scene(mesh);
  in_parallel(views.size(),
              [&](std::size_t i) { overlaps[i] = overlap(views[i], Silhouette(views[i], scene, mesh.origin)); });
  return overlaps;
}

Mesh hull_of(std::span<const ShapeView> views, const Eigen::AlignedBox3d& box) {
  constexpr double kCells = 64;
  return closed_surface(hull_with_cells({views, box, {.most_dissent = 1, .must_see = 0.2}}, kCells)).mesh;
}

double mean(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(std::max<std::size_t>(1, values.size()));
}

constexpr std::size_t kFewestOnASide = 3;

/// The view from which on the hull of the last ones fits best and that of the first ones least.
std::size_t best_step(std::span<const ShapeView> views, std::size_t first, std::size_t last,
                      const Eigen::AlignedBox3d& box) {
  const std::vector<double> early = overlaps_with(views, hull_of(views.first(first), box)),
                            late = overlaps_with(views, hull_of(views.last(last), box));
  const auto step_at = [&](std::size_t begin) {
    double step = 0;
    for (std::size_t i = 0; i < views.size(); ++i) step += i < begin ? early[i] - late[i] : late[i] - early[i];
    return step;
  };
  std::size_t best = kFewestOnASide;
  for (std::size_t begin = best; begin + kFewestOnASide <= views.size(); ++begin)
    if (step_at(begin) > step_at(best)) best = begin;
  return best;
}

}  // namespace

std::vector<std::optional<OutlineFit>> outline_fits(std::span<const ShapeView> views, const Mesh& mesh,
                                                    double thin_px) {
  std::vector<std::optional<OutlineFit>> fits(views.size());
  const RayScene scene(mesh);
  in_parallel(views.size(), [&](std::size_t i) {
    if (views[i].outline.empty() || views[i].before_sheet) return;
    const Silhouette silhouette(views[i], scene, mesh.origin);
    fits[i] = OutlineFit{overlap(views[i], silhouette), thin_missing(views[i], silhouette, thin_px)};
  });
  return fits;
}

std::optional<Split> split_of_outlines(std::span<const ShapeView> views, const Eigen::AlignedBox3d& box) {
  constexpr std::size_t kFewest = 9, kUnsure = 3;
  constexpr double kWell = 0.9, kBadly = 0.8, kMost = 0.1;  // overlaps, of all but so many
  std::vector<ShapeView> outlined;
  std::vector<std::size_t> number;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (!views[i].outline.empty() && !views[i].before_sheet) outlined.push_back(views[i]), number.push_back(i);
  if (outlined.size() < kFewest) return std::nullopt;
  const std::span<const ShapeView> all = outlined;
  const std::vector<double> together = overlaps_with(all, hull_of(all, box));
  if (quantile(together, 0.5) > kBadly) return std::nullopt;

  const std::size_t third = all.size() / 3;
  std::size_t begin = best_step(all, third, third, box);
  const std::size_t unsure = std::min({kUnsure, begin - kFewestOnASide, all.size() - kFewestOnASide - begin});
  begin = best_step(all, begin - unsure, all.size() - begin - unsure, box);

  const Mesh before = hull_of(all.first(begin), box), after = hull_of(all.subspan(begin), box);
  std::vector<double> own = overlaps_with(all.first(begin), before);
  const std::vector<double> own_after = overlaps_with(all.subspan(begin), after);
  own.insert(own.end(), own_after.begin(), own_after.end());
  if (quantile(own, kMost) < kWell) return std::nullopt;
  return Split{.after = number[begin - 1], .within = mean(own), .across = mean(together)};
}

}  // namespace sheen
