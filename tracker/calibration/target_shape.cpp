// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/target_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr int kFewestSightings = 3, kFewestPoints = 8;

double squared_sum(const Bundle& bundle) {
  double sum = 0;
  for (const Eigen::Vector2d& r : residuals(bundle)) sum += r.squaredNorm();
  return sum;
}

}  // namespace

TargetShape estimate_target_shape(std::span<const Eigen::Vector3d> target, const Calibration& calibration) {
  std::vector<int> sightings(target.size(), 0), place(target.size(), -1);
  for (const TargetView& view : calibration.used)
    for (const TargetSighting& s : view.sightings) ++sightings[s.point];
  Bundle bundle{.camera = calibration.camera, .free = {.intrinsics = calibration.fit->free}};
  for (std::size_t i = 0; i < target.size(); ++i)
    if (sightings[i] >= kFewestSightings) {
      place[i] = static_cast<int>(bundle.points.size());
      bundle.points.push_back(target[i]);
    }
  const int count = static_cast<int>(bundle.points.size());
  if (count < kFewestPoints) throw Error("too few points of the target are seen often enough to judge its shape");
  for (const CalibratedView& view : calibration.views)
    if (view.used) bundle.camera_from_object.push_back(view.camera_from_target);
  for (std::size_t view = 0; view < calibration.used.size(); ++view)
    for (const TargetSighting& s : calibration.used[view].sightings)
      if (place[s.point] >= 0) bundle.sightings.push_back({static_cast<int>(view), place[s.point], s.pixel});

  const std::vector<Eigen::Vector3d> given = bundle.points;
  solve(bundle);
  const double before = squared_sum(bundle);
  bundle.free.points = true;
  solve(bundle);
  const double after = squared_sum(bundle);

  Eigen::Matrix3Xd found(3, count), said(3, count);
  for (int i = 0; i < count; ++i) {
    found.col(i) = bundle.points[i];
    said.col(i) = given[i];
  }
  const Eigen::Matrix4d said_from_found = Eigen::umeyama(found, said);
  TargetShape shape;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d off = (said_from_found * found.col(i).homogeneous()).hnormalized() - said.col(i);
    shape.out_of_plane_m = std::max(shape.out_of_plane_m, std::abs(off.z()));
    shape.in_plane_m = std::max(shape.in_plane_m, off.head<2>().norm());
  }
  const double more = 3.0 * count - 7;  // a similarity of all points changes no image
  const double values = 2.0 * static_cast<double>(bundle.sightings.size());
  const double unknowns =
      calibration.fit->parameters() + 6.0 * static_cast<double>(bundle.camera_from_object.size()) + more;
  shape.rms_px = std::sqrt(2 * after / values);
  if (values > unknowns && after > 0) shape.significance = (before - after) / more / (after / (values - unknowns));
  return shape;
}

}  // namespace sheen
