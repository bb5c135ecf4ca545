// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape_measures.h"

#include <algorithm>
#include <cmath>

#include "common/base/order_statistics.h"
#include "reconstructor/shape/object_hull.h"
#include "reconstructor/shape/outline_fit.h"
#include "reconstructor/shape/shape_images.h"

namespace sheen {
namespace {

// What they show has moved where pairs of views part in two so far, and fit so well otherwise: shares of windows alike.
constexpr double kMovedApart = 0.25, kMovedWithin = 0.6;

/// Where it is not known, cameras are held upright.
Eigen::Vector3d up_of(const ShapeImages& images) {
  if (!images.sheet.known().isEmpty()) return Eigen::Vector3d::UnitZ();
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const PosedCamera& camera : images.cameras)
    up -= camera.camera_from_object.rotation.conjugate() * Eigen::Vector3d::UnitY();
  return up.normalized();
}

std::vector<Eigen::Vector3d> directions_of(std::span<const PosedCamera> cameras, const Eigen::Vector3d& middle) {
  std::vector<Eigen::Vector3d> directions;
  for (const PosedCamera& camera : cameras)
    directions.push_back((camera_centre(camera.camera_from_object) - middle).normalized());
  return directions;
}

double angle_to_third_nearest(const std::vector<Eigen::Vector3d>& directions) {
  constexpr std::size_t kThird = 2;
  std::vector<double> angles;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    std::vector<double> to_others;
    for (std::size_t j = 0; j < directions.size(); ++j)
      if (j != i) to_others.push_back(std::acos(std::clamp(directions[i].dot(directions[j]), -1.0, 1.0)));
    std::sort(to_others.begin(), to_others.end());
    angles.push_back(to_others[std::min(kThird, to_others.size() - 1)]);
  }
  return median(angles);
}

std::optional<double> median_off_px(std::span<const PairAgreement> pairs) {
  constexpr std::size_t kFewest = 6;
  std::vector<double> off;
  for (const PairAgreement& pair : pairs)
    if (pair.across_px) off.push_back(*pair.across_px);
  return off.size() < kFewest ? std::nullopt : std::optional(median(off));
}

/// Of the windows that others ask each view about: it shows the same. Empty where it is asked about few, since it looks
/// at what has no texture.
std::vector<std::optional<double>> shares_alike(std::span<const PairAgreement> pairs, std::size_t views) {
  constexpr double kFew = 0.5;  // of the usual number
  std::vector<double> asked(views, 0), alike(views, 0);
  for (const PairAgreement& pair : pairs) asked[pair.in] += pair.windows, alike[pair.in] += pair.alike;
  const double usual = median(std::vector<double>(asked));
  std::vector<std::optional<double>> shares(views);
  for (std::size_t i = 0; i < views; ++i)
    if (asked[i] > 0 && asked[i] >= kFew * usual) shares[i] = alike[i] / asked[i];
  return shares;
}

/// Of the mesh's area: within `margin` of where the space ends. The floor of the stage is no end: objects stand on it.
double share_at_border(const Mesh& mesh, const ObjectPlace& place, bool on_stage, double margin) {
  double at_border = 0, all = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d at =
        (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)).cast<double>() / 3 + mesh.origin;
    const double area = mesh.area_normal(t).norm();
    Eigen::Vector3d from_low = at - place.space.min();
    if (on_stage) from_low.z() = 2 * margin;
    all += area;
    if (std::min(from_low.minCoeff(), (place.space.max() - at).minCoeff()) < margin) at_border += area;
  }
  return at_border / std::max(all, 1e-300);
}

}  // namespace

ShapeMeasures measure_shape(const ShapeImages& images, const ObjectPlace& place, std::span<const ShapeView> views,
                            std::span<const PairAgreement> pairs, const Mesh& mesh, double cell) {
  const Eigen::Vector3d middle = place.box.center();
  const std::vector<Eigen::Vector3d> directions = directions_of(images.cameras, middle);
  std::vector<double> scales, pixels;  // of the views in their images; a pixel of these on the object
  for (std::size_t i = 0; i < views.size(); ++i) {
    scales.push_back(views[i].camera.camera.fx / images.cameras[i].camera.fx);
    pixels.push_back((images.cameras[i].camera_from_object * middle).norm() / images.cameras[i].camera.fx);
  }
  ShapeMeasures measures{.moved = place.moved,
                         .off_px = median_off_px(pairs),
                         .angle_between = angle_to_third_nearest(directions),
                         .sight = sight_of(mesh, images.cameras, up_of(images)),
                         .at_border = share_at_border(mesh, place, !images.sheet.known().isEmpty(), 1.5 * cell),
                         .cell_px = cell / median(pixels)};
  if (measures.off_px) *measures.off_px /= median(scales);
  // Where surfaces tell it, too, they tell it more exactly.
  if (const auto split = best_split(pairs, views.size());
      split && split->within > kMovedWithin && split->within - split->across > kMovedApart)
    measures.moved = split;
  const auto fits = outline_fits(views, mesh, 2 * cell / median(pixels) * median(scales));
  const std::vector<std::optional<double>> alike = shares_alike(pairs, views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    ShapeViewMeasures& view = measures.views.emplace_back();
    view.name = views[i].name.empty() ? "image " + std::to_string(images.used[i] + 1) : views[i].name;
    view.cut = images.cut[i];
    view.outlined = !views[i].outline.empty();
    if (fits[i]) view.overlap = fits[i]->overlap, view.thin_missing = fits[i]->thin_missing;
    view.alike = alike[i];
  }
  const auto beside =
      std::max_element(directions.begin(), directions.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
        return a.dot(measures.sight.faces_aside) < b.dot(measures.sight.faces_aside);
      });
  measures.beside = measures.views[beside - directions.begin()].name;
  return measures;
}

}  // namespace sheen
