// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/closed_surface.h"
#include "reconstructor/shape/depth_fusion.h"
#include "reconstructor/shape/depth_search.h"
#include "reconstructor/shape/neighbour_views.h"
#include "reconstructor/shape/object_box.h"
#include "reconstructor/shape/outline_evidence.h"
#include "reconstructor/shape/simplification.h"

#include "reconstructor/shape/visual_hull.h"

namespace sheen {
namespace {

constexpr std::size_t kNeighbours = 6;                  // that a view is compared with
constexpr double kCoarseWidth_px = 320;                 // of an image in which the object is looked for
constexpr double kCoarseCells = 64, kRangeCells = 128;  // along the longest side of a box
constexpr double kMostCells = 400;
constexpr double kCoherent = 0.98;  // overlap of outlines and hull from where masks are believed
// Masks that agree show also what few images have in their frame.
constexpr HullRule kStrict{.most_dissent = 1, .must_see = 0.2}, kTolerant{.may_dissent = 0.2};
constexpr double kSheet_px = 1.5;
constexpr double kFinest_px = 1.0;    // cell of the fused field, pixels
constexpr double kTriangle_px = 3.5;  // side of a triangle, pixels

/// The images that shape is found from, as they are read again and again.
struct Images {
  const RefinementImages& all;
  std::vector<std::size_t> used;
  std::vector<PosedCamera> cameras;          ///< of the used ones
  std::vector<PlainBackground> backgrounds;  ///< likewise
  Eigen::AlignedBox2d stage;                 ///< in the plane z = 0; empty where no tags were seen

  Capture read(std::size_t i) const { return all.read(used[i]); }
};

ShapeView marked_view(const Capture& capture, const PixelBox& part, double scale, const PlainBackground& background) {
  ShapeView view = shape_view(capture, part, scale);
  if (view.outline.empty() && background.found) mark_background(background, view);
  return view;
}

/// By where the corners of the stage's tags lie, which a session's captures know.
void extend_by_tags(const Capture& capture, Eigen::AlignedBox2d& stage) {
  const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
  for (const TagObservation& tag : capture.tags) {
    if (!tag.used) continue;
    for (const Eigen::Vector2d& corner : tag.corners) {
      const auto ray = capture.camera.ray(corner);
      if (!ray) continue;
      const Eigen::Vector3d eye = object_from_camera.translation, down = object_from_camera.rotation * *ray;
      if (down.z() < 0) stage.extend((eye - eye.z() / down.z() * down).head<2>().eval());
    }
  }
}

/// Whole images, small, and what their backgrounds look like.
std::vector<ShapeView> coarse_views(Images& images) {
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < images.used.size(); ++i) {
    const Capture capture = images.read(i);
    const Camera& camera = capture.camera;
    const PixelBox whole{0, 0, camera.width, camera.height};
    const double scale = std::min(1.0, kCoarseWidth_px / std::max(camera.width, camera.height));
    ShapeView view = shape_view(capture, whole, scale);
    images.backgrounds.push_back(view.outline.empty() ? plain_background(view) : PlainBackground{});
    if (view.outline.empty() && images.backgrounds.back().found) mark_background(images.backgrounds.back(), view);
    views.push_back(std::move(view));
    extend_by_tags(capture, images.stage);
  }
  return views;
}

BlockField hull_with_cells(const VisualHull& hull, double cells) {
  return hull_field(hull, lattice_over(hull.box(), hull.box().sizes().maxCoeff() / cells), in_parallel);
}

/// The hull in a box that fits it.
struct Hull {
  VisualHull hull;
  bool coherent = false;
};

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

/// Mean overlap (intersection over union) of what may be the object in the views with the hull's mesh.
double overlap_with(std::span<const ShapeView> views, const Mesh& hull) {
  const RayScene scene(hull);
  std::vector<double> overlaps(views.size(), -1);
  const Eigen::Vector3d& origin = hull.origin;
  in_parallel(views.size(), [&](std::size_t i) {
    const ShapeView& view = views[i];
    if (view.outline.empty()) return;
    const Camera& camera = view.camera.camera;
    const Rigid3 object_from_view = view.camera.camera_from_object.inverse();
    double both = 0, either = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
        const bool hit = scene.occluded({.origin = (object_from_view.translation - origin).cast<float>(),
                                         .direction = (object_from_view.rotation * ray).cast<float>()});
        const bool object = view.outline.at(x, y) != static_cast<std::uint8_t>(Outline::kBackground);
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

/// Whether outlines and hull are of one object, so that one dissenter is enough for a mask that is off.
Hull find_hull(std::span<const ShapeView> views, const Eigen::AlignedBox3d& seen) {
  if (!VisualHull(views, seen, {}).has_outlines()) return {.hull = {views, seen, {}}};
  const Eigen::AlignedBox3d strict = tight_box(views, seen, kStrict);
  if (!strict.isEmpty()) {
    VisualHull hull(views, strict, kStrict);
    const Mesh mesh = closed_surface(hull_with_cells(hull, kRangeCells)).mesh;
    if (!mesh.triangles.empty() && overlap_with(views, mesh) >= kCoherent)
      return {.hull = std::move(hull), .coherent = true};
  }
  const Eigen::AlignedBox3d box = tight_box(views, seen, kTolerant);
  if (box.isEmpty())
    throw Error("the outlines of the images have no place in common: check the poses, and that all show one object");
  return {.hull = {views, box, kTolerant}};
}

/// On the stage, where that is known: above its sheet, between its tags.
Eigen::AlignedBox3d on_stage(const Images& images, const Eigen::AlignedBox3d& box) {
  if (images.stage.isEmpty()) return box;
  std::vector<double> pixels;
  for (const PosedCamera& camera : images.cameras)
    pixels.push_back((camera.camera_from_object * box.center()).norm() / camera.camera.fx);
  const double sheet = kSheet_px * median(pixels);  // so thick depths of it may be
  const Eigen::AlignedBox2d& stage = images.stage;
  return box.intersection({Eigen::Vector3d(stage.min().x(), stage.min().y(), sheet),
                           Eigen::Vector3d(stage.max().x(), stage.max().y(), box.max().z())});
}

/// Where the object is, from small images.
Eigen::AlignedBox3d find_box(Images& images) {
  const std::vector<ShapeView> views = coarse_views(images);
  const bool outlines = std::any_of(views.begin(), views.end(), [](const ShapeView& v) { return !v.outline.empty(); });
  const Eigen::AlignedBox3d seen =
      on_stage(images, box_seen_by((outlines ? kStrict : HullRule()).must_see, images.cameras));
  if (seen.isEmpty()) throw Error("the images show nothing above the stage: the cameras look elsewhere");
  return find_hull(views, seen).hull.box();
}

/// Parts of the images round the object, at a scale at which its box has about so many pixels.
std::vector<ShapeView> fine_views(const Images& images, const Eigen::AlignedBox3d& box, double pixels) {
  std::vector<PixelBox> parts;
  std::vector<double> areas;
  for (const PosedCamera& camera : images.cameras) {
    parts.push_back(part_with(box, camera));
    areas.push_back(double(parts.back().width()) * parts.back().height());
  }
  const double scale = std::min(1.0, std::sqrt(pixels / std::max(1.0, median(areas))));
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < images.used.size(); ++i) {
    if (parts[i].empty()) parts[i] = {0, 0, 1, 1};
    views.push_back(marked_view(images.read(i), parts[i], scale, images.backgrounds[i]));
  }
  return views;
}

/// From the first to the last surface of the hull on each pixel's ray, with a margin.
DepthRange range_in(const ShapeView& view, const RayScene& hull, const Eigen::Vector3d& origin, double margin,
                    double farthest) {
  const Camera& camera = view.camera.camera;
  DepthRange range{ImageF(camera.width, camera.height, 1), ImageF(camera.width, camera.height, 1)};
  const Rigid3 object_from_view = view.camera.camera_from_object.inverse();
  const Eigen::Vector3d eye = object_from_view.translation - origin;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray =
          object_from_view.rotation * Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      const Hit front = hull.intersect({.origin = eye.cast<float>(), .direction = ray.cast<float>()});
      if (!front) continue;
      const Hit back =
          hull.intersect({.origin = (eye + farthest * ray).cast<float>(), .direction = (-ray).cast<float>()});
      if (!back) continue;
      range.nearest.at(x, y) = static_cast<float>(std::max(0.1 * front.distance, front.distance - margin));
      range.farthest.at(x, y) = static_cast<float>(farthest - back.distance + margin);
    }
  return range;
}

/// The size of a pixel on the object, metres: median over the views.
double pixel_on_object(std::span<const ShapeView> views, const Eigen::Vector3d& middle) {
  std::vector<double> sizes;
  for (const ShapeView& view : views)
    sizes.push_back((view.camera.camera_from_object * middle).norm() / view.camera.camera.fx);
  return median(sizes);
}

struct Depths {
  std::vector<DepthMap> maps;
  double share = 0;  ///< of the pixels in range that are kept
};

std::vector<ImageF> depths_in(std::span<const DepthMap> maps) {
  std::vector<ImageF> depths;
  for (const DepthMap& map : maps) depths.push_back(map.depth);
  return depths;
}

/// Tells of each view that is done, one call at a time.
class ViewsDone {
 public:
  ViewsDone(std::size_t steps, const StepsDone& progress) : steps_(steps), progress_(progress) {}
  void one() {
    const std::lock_guard lock(mutex_);
    if (progress_) progress_(++done_, steps_);
  }

 private:
  std::mutex mutex_;
  std::size_t done_ = 0, steps_;
  const StepsDone& progress_;
};

Depths find_depths(std::span<const ShapeView> views, const Hull& hull, const StepsDone& progress) {
  const Eigen::AlignedBox3d& box = hull.hull.box();
  const BlockField field = hull_with_cells(hull.hull, kRangeCells);
  const Mesh mesh = closed_surface(field).mesh;
  if (mesh.triangles.empty()) throw Error("the outlines of the images leave no object: check masks and poses");
  const RayScene scene(mesh);
  const double margin = (hull.coherent ? 1 : 3) * field.lattice().cell;

  std::vector<PosedCamera> cameras;
  for (const ShapeView& view : views) cameras.push_back(view.camera);
  const auto neighbours = neighbour_views(cameras, box.center(), kNeighbours);
  std::vector<std::vector<const ShapeView*>> others(views.size());
  for (std::size_t i = 0; i < views.size(); ++i)
    for (const std::size_t j : neighbours[i]) others[i].push_back(&views[j]);

  std::vector<DepthRange> ranges(views.size());
  std::vector<DepthMap> maps(views.size());
  ViewsDone done(2 * views.size(), progress);
  in_parallel(views.size(), [&](std::size_t i) {
    const double farthest = (views[i].camera.camera_from_object * box.center()).z() + 2 * box.diagonal().norm();
    ranges[i] = range_in(views[i], scene, mesh.origin, margin, farthest);
    maps[i] = search_depth(views[i], others[i], ranges[i], i);
    done.one();
  });
  const auto depths_of = [&](const std::vector<ImageF>& all, std::size_t i) {
    std::vector<const ImageF*> of_others;
    for (const std::size_t j : neighbours[i]) of_others.push_back(&all[j]);
    return of_others;
  };
  const std::vector<ImageF> first = depths_in(maps);
  in_parallel(views.size(), [&](std::size_t i) {
    maps[i] =
        search_depth_again(views[i], others[i], depths_of(first, i), ranges[i], std::move(maps[i]), views.size() + i);
  });
  const std::vector<ImageF> second = depths_in(maps);
  std::vector<ImageU8> agreeing(views.size());
  in_parallel(views.size(), [&](std::size_t i) {
    agreeing[i] = agreeing_neighbours(views[i], maps[i], others[i], depths_of(second, i));
  });
  std::size_t kept = 0, looked_at = 0;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (int y = 0; y < agreeing[i].height(); ++y)
      for (int x = 0; x < agreeing[i].width(); ++x) {
        if (!(ranges[i].farthest.at(x, y) > 0)) continue;
        ++looked_at;
        if (agreeing[i].at(x, y) >= 2)
          ++kept;
        else
          maps[i].depth.at(x, y) = 0;
      }
  return {std::move(maps), looked_at == 0 ? 0 : static_cast<double>(kept) / static_cast<double>(looked_at)};
}

std::vector<int> views_of_vertices(const Mesh& mesh, std::span<const ShapeView> views, const Depths& depths,
                                   double reach) {
  std::vector<int> seeing(mesh.vertices.size());
  in_parallel(seeing.size(), [&](std::size_t v) {
    seeing[v] = views_of(mesh.vertices[v].cast<double>() + mesh.origin, views, depths.maps, reach);
  });
  return seeing;
}

/// The box of what the views see, but for what lies far off.
Eigen::AlignedBox3d box_of_seen(std::span<const ShapeView> views, const Depths& depths,
                                const Eigen::AlignedBox3d& box) {
  constexpr double kLeftOut = 0.005, kMargin = 0.03;  // at either side; of the diagonal
  constexpr int kEvery = 4;                           // pixels
  std::array<std::vector<double>, 3> places;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera& camera = views[i].camera.camera;
    const Rigid3 object_from_view = views[i].camera.camera_from_object.inverse();
    for (int y = 0; y < camera.height; y += kEvery)
      for (int x = 0; x < camera.width; x += kEvery) {
        const double depth = depths.maps[i].depth.at(x, y);
        if (!(depth > 0)) continue;
        const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
        const Eigen::Vector3d point = object_from_view * (depth * ray);
        for (int axis = 0; axis < 3; ++axis) places[axis].push_back(point[axis]);
      }
  }
  if (places[0].empty()) throw Error("the images agree about no surface: check the poses, and that nothing moved");
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = quantile(places[axis], kLeftOut);
    high[axis] = quantile(places[axis], 1 - kLeftOut);
  }
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMargin * (high - low).norm());
  return Eigen::AlignedBox3d(low - margin, high + margin).intersection(box);
}

double area_of(const Mesh& mesh) {
  double twice = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) twice += mesh.area_normal(t).norm();
  return twice / 2;
}

}  // namespace

FoundShape find_shape(const RefinementImages& images, const ShapeOptions& options, const StepsDone& progress) {
  const Eigen::Vector3d middle = box_seen_by(HullRule().must_see, images.cameras).center();
  Images used{.all = images, .used = spread_views(images.cameras, middle, options.most_views)};
  for (const std::size_t i : used.used) used.cameras.push_back(images.cameras[i]);
  const Eigen::AlignedBox3d box = find_box(used);
  const std::vector<ShapeView> views = fine_views(used, box, options.object_pixels);
  const Hull hull = find_hull(views, box);
  const Depths depths = find_depths(views, hull, progress);

  const double pixel = pixel_on_object(views, box.center());
  const Eigen::AlignedBox3d tight =
      hull.hull.has_outlines() ? hull.hull.box() : box_of_seen(views, depths, hull.hull.box());
  const double cell = std::max(kFinest_px * pixel, tight.sizes().maxCoeff() / kMostCells);
  const BlockField field =
      fused_surface(views, depths.maps, hull.hull, hull.coherent, lattice_over(tight, cell), in_parallel);
  const Mesh fine = closed_surface(field).mesh;
  if (fine.triangles.empty()) throw Error("the images agree about no surface: check the poses");
  std::vector<float> detail;
  for (const int n : views_of_vertices(fine, views, depths, 2 * cell)) detail.push_back(n >= 2 ? 1.0f : 0.2f);
  const std::size_t triangles =
      options.triangles > 0
          ? options.triangles
          : std::clamp<std::size_t>(area_of(fine) / (0.433 * std::pow(kTriangle_px * pixel, 2)), 2'000, 60'000);

  FoundShape found{.mesh = simplified(fine, triangles, detail),
                   .outlines = hull.hull.outlines(),
                   .coherent = hull.coherent,
                   .views = views.size(),
                   .depth_share = depths.share,
                   .cell = cell};
  const std::vector<int> seeing = views_of_vertices(found.mesh, views, depths, 2 * cell);
  for (std::size_t v = 0; v < seeing.size(); ++v) {
    const double outside = hull.hull.distance(found.mesh.vertices[v].cast<double>() + found.mesh.origin);
    found.evidence.push_back(seeing[v] >= 2                                                ? ShapeEvidence::kSeen
                             : hull.hull.has_outlines() && std::abs(outside) <= 1.5 * cell ? ShapeEvidence::kOutline
                                                                                           : ShapeEvidence::kGuessed);
  }
  return found;
}

}  // namespace sheen
