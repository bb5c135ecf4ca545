// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/surfaces_apart.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "tests/bench/surface_distance.h"

namespace sheen {
namespace {

/// A place on a mesh, in its file's frame.
struct SurfacePoint {
  Eigen::Vector3d place;
  std::size_t triangle = 0;
};
/// Spread evenly.
std::vector<SurfacePoint> points_on(const Mesh& mesh) {
  constexpr std::size_t kPoints = 30'000;
  std::vector<double> areas;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) areas.push_back(mesh.area_normal(t).norm());
  std::mt19937 chance(1);
  std::discrete_distribution<std::size_t> triangle(areas.begin(), areas.end());
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const std::size_t t = triangle(chance);
    const double u = std::sqrt(part(chance)), v = part(chance);  // even over the triangle
    const Eigen::Vector3d a = mesh.corner(t, 0).cast<double>(), b = mesh.corner(t, 1).cast<double>(),
                          c = mesh.corner(t, 2).cast<double>();
    points.push_back({mesh.origin + (1 - u) * a + u * (1 - v) * b + u * v * c, t});
  }
  return points;
}

/// The parts of a surface that a camera sees.
std::vector<SurfacePoint> seen_points(const Mesh& mesh, std::span<const PosedCamera> cameras) {
  const RayScene scene(mesh);
  std::vector<SurfacePoint> seen;
  for (const SurfacePoint& point : points_on(mesh)) {
    const Eigen::Vector3d normal = mesh.area_normal(point.triangle).cast<double>();
    const auto sees = [&](const PosedCamera& camera) {
      const Eigen::Vector3d to_eye = camera_centre(camera.camera_from_object) - point.place;
      const auto pixel = camera.camera.project(camera.camera_from_object * point.place);
      return to_eye.dot(normal) > 0 && pixel && camera.camera.contains(*pixel) &&
             !scene.occluded({.origin = (point.place - mesh.origin).cast<float>(),
                              .direction = to_eye.cast<float>(),
                              .near = 1e-4f,
                              .far = 1});
    };
    if (std::any_of(cameras.begin(), cameras.end(), sees)) seen.push_back(point);
  }
  return seen;
}

}  // namespace

Apart apart(const Mesh& from, const Mesh& to, std::span<const PosedCamera> cameras) {
  const SurfaceDistance distance(to);
  std::vector<double> distances_mm;
  for (const SurfacePoint& point : seen_points(from, cameras)) distances_mm.push_back(1e3 * distance.to(point.place));
  if (distances_mm.empty()) return {HUGE_VAL, HUGE_VAL};
  return {median(distances_mm), quantile(distances_mm, 0.9)};
}

}  // namespace sheen
