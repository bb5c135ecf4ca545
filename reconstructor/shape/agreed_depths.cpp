// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/agreed_depths.h"

#include <algorithm>
#include <array>
#include <mutex>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/closed_surface.h"
#include "reconstructor/shape/depth_search.h"
#include "reconstructor/shape/neighbour_views.h"

namespace sheen {
namespace {

constexpr std::size_t kNeighbours = 6;  // that a view is compared with

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

}  // namespace

AgreedDepths find_depths(std::span<const ShapeView> views, const ObjectHull& hull, const StepsDone& progress) {
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

Eigen::AlignedBox3d box_of_seen(std::span<const ShapeView> views, const AgreedDepths& depths,
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

}  // namespace sheen
