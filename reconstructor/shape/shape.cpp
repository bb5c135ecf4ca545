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
#include "reconstructor/shape/rim_alignment.h"
#include "reconstructor/shape/shape_images.h"
#include "reconstructor/shape/simplification.h"
#include "reconstructor/shape/view_agreement.h"

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

/// As many triangles as the images resolve.
std::size_t resolved_triangles(const Mesh& mesh, double pixel) {
  double twice_area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) twice_area += mesh.area_normal(t).norm();
  const double side = kTriangle_px * pixel, triangle = std::sqrt(3.0) / 4 * side * side;
  return std::clamp<std::size_t>(static_cast<std::size_t>(twice_area / 2 / triangle), 2'000, 60'000);
}

std::vector<ShapeEvidence> evidence_of(const Mesh& mesh, std::span<const ShapeView> views, const AgreedDepths& depths,
                                       const VisualHull& hull, double cell) {
  std::vector<ShapeEvidence> evidence(mesh.vertices.size());
  in_parallel(evidence.size(), [&](std::size_t v) {
    const Eigen::Vector3d place = mesh.vertices[v].cast<double>() + mesh.origin;
    const bool on_outlines = hull.has_outlines() && std::abs(hull.distance(place)) <= 1.5 * cell;
    evidence[v] = views_of(place, views, depths.maps, 2 * cell) >= 2 ? ShapeEvidence::kSeen
                  : on_outlines                                      ? ShapeEvidence::kOutline
                                                                     : ShapeEvidence::kGuessed;
  });
  return evidence;
}

/// As finely as the images show it.
struct FineSurface {
  Mesh mesh;
  std::vector<PairAgreement> pairs;  ///< of the views
  double cell = 0, depth_share = 0;
};

/// Takes the grey of the views away: it is not needed any more, and memory is.
FineSurface find_surface(std::vector<ShapeView>& views, const ObjectHull& found, double pixel,
                         const StepsDone& progress) {
  const VisualHull& hull = found.hull;
  const AgreedDepths depths = find_depths(views, found, progress);
  std::vector<PairAgreement> pairs = agreement_of_pairs(views, depths.maps, hull.box().center());
  for (ShapeView& view : views) view.grey = {};
  const Eigen::AlignedBox3d box = hull.has_outlines() ? hull.box() : box_of_seen(views, depths, hull.box());
  FineSurface fine{.pairs = std::move(pairs),
                   .cell = std::max(kFinest_px * pixel, box.sizes().maxCoeff() / kMostCells),
                   .depth_share = depths.share};
  const Lattice lattice = lattice_over(box, fine.cell);
  fine.mesh = closed_surface(fused_surface(views, depths.maps, hull, found.coherent, lattice, in_parallel)).mesh;
  if (fine.mesh.triangles.empty()) throw Error("the images agree about no surface: check the poses");
  fine.mesh.evidence = evidence_of(fine.mesh, views, depths, hull, fine.cell);
  return fine;
}

/// Triangles go where the images saw detail.
std::vector<float> detail_of(std::span<const ShapeEvidence> evidence) {
  std::vector<float> detail;
  for (const ShapeEvidence of : evidence) detail.push_back(of == ShapeEvidence::kSeen ? 1.0f : 0.2f);
  return detail;
}

}  // namespace

FoundShape find_shape(const RefinementImages& images, const ShapeOptions& options, const StepsDone& progress) {
  const Eigen::Vector3d middle = box_seen_by(HullRule().must_see, images.cameras).center();
  ShapeImages used(images, middle, options.most_views, options.from);
  const ObjectPlace place = find_place(used);
  const Eigen::AlignedBox3d& box = place.box;
  std::vector<ShapeView> views = fine_views(used, box, options.object_pixels);
  const ObjectHull hull = find_hull(views, box);
  const double pixel = pixel_on_object(views, box.center());
  FineSurface fine = find_surface(views, hull, pixel, progress);

  const std::size_t triangles = options.triangles > 0 ? options.triangles : resolved_triangles(fine.mesh, pixel);
  const std::vector<float> detail = detail_of(fine.mesh.evidence);
  FoundShape found{.mesh = simplified(std::move(fine.mesh), triangles, detail),
                   .outlines = hull.hull.outlines(),
                   .coherent = hull.coherent,
                   .stage_unconfirmed = images.stage && !used.before_sheet && hull.hull.outlines() == 0,
                   .views = views.size(),
                   .depth_share = fine.depth_share,
                   .cell = fine.cell};
  if (hull.hull.has_outlines()) move_rims_to_outlines(views, pixel, found.mesh);
  found.measures = measure_shape(used, place, views, fine.pairs, found.mesh, fine.cell);
  return found;
}

}  // namespace sheen
