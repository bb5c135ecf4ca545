// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/object_hull.h"

#include <algorithm>
#include <vector>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/closed_surface.h"
#include "reconstructor/shape/object_box.h"
#include "reconstructor/shape/outline_fit.h"
#include "reconstructor/shape/silhouette.h"

namespace sheen {
namespace {

constexpr double kCoarseCells = 64;  // along the longest side of a box
constexpr double kCoherent = 0.98;   // overlap of outlines and hull from where masks are believed
// Masks that agree show also what few images have in their frame.
constexpr HullRule kStrict{.most_dissent = 1, .must_see = 0.2}, kTolerant{.may_dissent = 0.2};
// Beside a sheet outlines are known in part, and glows and shadows touch them. Of few, none may dissent: what one more
// would leave of the space above is much.
constexpr HullRule kOnSheet{.may_dissent = 0.05, .must_see = 0.2};
constexpr double kCoherentOnSheet = 0.9;
constexpr double kSheet_px = 1.5;  // so thick depths of the stage's sheet may be

Eigen::AlignedBox3d tight_box(std::span<const ShapeView> views, const Eigen::AlignedBox3d& box, const HullRule& rule) {
  constexpr int kRounds = 3;
  Eigen::AlignedBox3d tight = box;
  for (int round = 0; round < kRounds; ++round) {
    const BlockField field = hull_with_cells({views, tight, rule}, kCoarseCells);
    const Mesh piece = closed_surface(field).mesh;  // what else is left of the box lies out of most views' sight
    if (piece.triangles.empty()) return {};
    Eigen::AlignedBox3d within;
    for (const Eigen::Vector3f& vertex : piece.vertices) within.extend(vertex.cast<double>() + piece.origin);
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(2 * field.lattice().cell);
    const Eigen::AlignedBox3d cut = Eigen::AlignedBox3d(within.min() - margin, within.max() + margin).intersection(box);
    const bool hardly = cut.volume() > 0.8 * tight.volume();
    tight = cut;
    if (hardly) break;
  }
  return tight;
}

/// Mean overlap (intersection over union) of what may be the object in the views with the hull's mesh. What is unknown
/// beside a sheet is nothing to judge by.
double overlap_with(std::span<const ShapeView> views, const Mesh& hull) {
  const RayScene scene(hull);
  std::vector<double> overlaps(views.size(), -1);
  in_parallel(views.size(), [&](std::size_t i) {
    const ShapeView& view = views[i];
    if (view.outline.empty()) return;
    const Silhouette silhouette(view, scene, hull.origin);
    double both = 0, either = 0;
    for (int y = 0; y < view.outline.height(); ++y)
      for (int x = 0; x < view.outline.width(); ++x) {
        const auto mark = static_cast<Outline>(view.outline.at(x, y));
        if (view.before_sheet && mark == Outline::kUnknown) continue;
        const bool hit = silhouette.has(x, y), object = mark != Outline::kBackground;
        both += hit && object ? 1 : 0;
        either += hit || object ? 1 : 0;
      }
    if (either > 0) overlaps[i] = both / either;
  });
  double sum = 0;
  std::size_t counted = 0;
  for (const double overlap : overlaps)
    if (overlap >= 0) sum += overlap, ++counted;
  return counted == 0 ? 0 : sum / static_cast<double>(counted);
}

/// On the stage, where that is known: above its sheet, between its tags.
Eigen::AlignedBox3d on_stage(const ShapeImages& images, const Eigen::AlignedBox3d& box) {
  const Eigen::AlignedBox2d& stage = images.sheet.known();
  if (stage.isEmpty()) return box;
  std::vector<double> pixels;
  for (const PosedCamera& camera : images.cameras)
    pixels.push_back((camera.camera_from_object * box.center()).norm() / camera.camera.fx);
  const double sheet = kSheet_px * median(pixels);
  return box.intersection({Eigen::Vector3d(stage.min().x(), stage.min().y(), sheet),
                           Eigen::Vector3d(stage.max().x(), stage.max().y(), box.max().z())});
}

}  // namespace

BlockField hull_with_cells(const VisualHull& hull, double cells) {
  return hull_field(hull, lattice_over(hull.box(), hull.box().sizes().maxCoeff() / cells), in_parallel);
}

ObjectHull find_hull(std::span<const ShapeView> views, const Eigen::AlignedBox3d& seen) {
  if (!VisualHull(views, seen, {}).has_outlines()) return {.hull = {views, seen, {}}};
  const bool on_sheet = std::any_of(views.begin(), views.end(), [](const ShapeView& v) { return v.before_sheet; });
  const HullRule& rule = on_sheet ? kOnSheet : kStrict;
  const Eigen::AlignedBox3d strict = tight_box(views, seen, rule);
  if (!strict.isEmpty()) {
    VisualHull hull(views, strict, rule);
    const Mesh mesh = closed_surface(hull_with_cells(hull, kRangeCells)).mesh;
    const double overlap = mesh.triangles.empty() ? 0 : overlap_with(views, mesh);
    if (overlap >= (on_sheet ? kCoherentOnSheet : kCoherent)) return {.hull = std::move(hull), .coherent = true};
  }
  if (on_sheet) return {.hull = {views, seen, {.outlines = false}}};
  const Eigen::AlignedBox3d box = tight_box(views, seen, kTolerant);
  if (box.isEmpty())
    throw Error("the outlines of the images have no place in common: check the poses, and that all show one object");
  return {.hull = {views, box, kTolerant}};
}

ObjectPlace find_place(ShapeImages& images) {
  const std::vector<ShapeView> views = coarse_views(images);
  const bool outlines = std::any_of(views.begin(), views.end(), [](const ShapeView& v) { return !v.outline.empty(); });
  const Eigen::AlignedBox3d seen =
      on_stage(images, box_seen_by((outlines ? kStrict : HullRule()).must_see, images.cameras));
  if (seen.isEmpty()) throw Error("the images show nothing above the stage: the cameras look elsewhere");
  const std::optional<Split> moved = split_of_outlines(views, seen);
  try {
    return {.box = find_hull(views, seen).hull.box(), .space = seen, .moved = moved};
  } catch (const Error&) {
    if (!moved) throw;
    throw Error(
        "the object moved after " + views[moved->after].name +
        ": the outlines before and after have no place in common; take the images anew, or leave those after out");
  }
}

}  // namespace sheen
