// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/parallel/for_each.h"
#include "reconstructor/shape/agreed_depths.h"
#include "reconstructor/shape/closed_surface.h"
#include "reconstructor/shape/depth_fusion.h"
#include "reconstructor/shape/object_box.h"
#include "reconstructor/shape/object_hull.h"
#include "reconstructor/shape/shape_images.h"
#include "reconstructor/shape/simplification.h"

namespace sheen {
namespace {

constexpr double kMostCells = 400;    // along the longest side of the fused field
constexpr double kFinest_px = 1.0;    // cell of the fused field, pixels
constexpr double kTriangle_px = 3.5;  // side of a triangle, pixels

/// The size of a pixel on the object, metres: median over the views.
double pixel_on_object(std::span<const ShapeView> views, const Eigen::Vector3d& middle) {
  std::vector<double> sizes;
  for (const ShapeView& view : views)
    sizes.push_back((view.camera.camera_from_object * middle).norm() / view.camera.camera.fx);
  return median(sizes);
}

std::vector<int> views_of_vertices(const Mesh& mesh, std::span<const ShapeView> views, const AgreedDepths& depths,
                                   double reach) {
  std::vector<int> seeing(mesh.vertices.size());
  in_parallel(seeing.size(), [&](std::size_t v) {
    seeing[v] = views_of(mesh.vertices[v].cast<double>() + mesh.origin, views, depths.maps, reach);
  });
  return seeing;
}

/// As many triangles as the images resolve.
std::size_t resolved_triangles(const Mesh& mesh, double pixel) {
  double twice_area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) twice_area += mesh.area_normal(t).norm();
  const double side = kTriangle_px * pixel, triangle = std::sqrt(3.0) / 4 * side * side;
  return std::clamp<std::size_t>(static_cast<std::size_t>(twice_area / 2 / triangle), 2'000, 60'000);
}

std::vector<ShapeEvidence> evidence_of(const Mesh& mesh, std::span<const ShapeView> views, const AgreedDepths& depths,
                                       const ObjectHull& hull, double cell) {
  std::vector<ShapeEvidence> evidence;
  const std::vector<int> seeing = views_of_vertices(mesh, views, depths, 2 * cell);
  for (std::size_t v = 0; v < seeing.size(); ++v) {
    const double outside = hull.hull.distance(mesh.vertices[v].cast<double>() + mesh.origin);
    const bool on_outlines = hull.hull.has_outlines() && std::abs(outside) <= 1.5 * cell;
    evidence.push_back(seeing[v] >= 2 ? ShapeEvidence::kSeen
                       : on_outlines  ? ShapeEvidence::kOutline
                                      : ShapeEvidence::kGuessed);
  }
  return evidence;
}

}  // namespace

FoundShape find_shape(const RefinementImages& images, const ShapeOptions& options, const StepsDone& progress) {
  const Eigen::Vector3d middle = box_seen_by(HullRule().must_see, images.cameras).center();
  ShapeImages used(images, middle, options.most_views);
  const Eigen::AlignedBox3d box = find_box(used);
  const std::vector<ShapeView> views = fine_views(used, box, options.object_pixels);
  const ObjectHull hull = find_hull(views, box);
  const AgreedDepths depths = find_depths(views, hull, progress);

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

  FoundShape found{
      .mesh = simplified(fine, options.triangles > 0 ? options.triangles : resolved_triangles(fine, pixel), detail),
      .outlines = hull.hull.outlines(),
      .coherent = hull.coherent,
      .views = views.size(),
      .depth_share = depths.share,
      .cell = cell};
  found.evidence = evidence_of(found.mesh, views, depths, hull, cell);
  return found;
}

}  // namespace sheen
