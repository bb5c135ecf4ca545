// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/silhouette_rims.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace sheen {
namespace {

constexpr float kOutside_px = 1.5f;     // where a ray beside a rim must pass without meeting anything
constexpr double kLeastLeverage = 0.3;  // of a rim's motion in the image, of what a motion across the ray would be

/// Value and gradient, bilinear; empty within a pixel of the border.
std::optional<Eigen::Vector3d> value_and_gradient(const ImageF& image, const Eigen::Vector2d& at) {
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  if (x < 1 || y < 1 || x + 2 >= image.width() || y + 2 >= image.height()) return {};
  const auto value = [&](double u, double v) {
    const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
    const double s = u - i, t = v - j;
    return (1 - t) * ((1 - s) * image.at(i, j) + s * image.at(i + 1, j)) +
           t * ((1 - s) * image.at(i, j + 1) + s * image.at(i + 1, j + 1));
  };
  return Eigen::Vector3d(value(at.x(), at.y()), (value(at.x() + 1, at.y()) - value(at.x() - 1, at.y())) / 2,
                         (value(at.x(), at.y() + 1) - value(at.x(), at.y() - 1)) / 2);
}

}  // namespace

std::vector<bool> on_contour(const Mesh& mesh, const Eigen::Vector3f& eye) {
  std::vector<std::uint8_t> sides(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool front = mesh.area_normal(t).dot(eye - mesh.corner(t, 0)) > 0;
    for (const std::uint32_t v : mesh.triangles[t]) sides[v] |= front ? 1 : 2;
  }
  std::vector<bool> contour(mesh.vertices.size());
  for (std::size_t v = 0; v < contour.size(); ++v) contour[v] = sides[v] == 3;
  return contour;
}

bool is_rim(const Eigen::Vector3f& vertex, const Eigen::Vector3f& normal, const Eigen::Vector3f& eye, double focal,
            const RayScene& scene) {
  const float distance = (vertex - eye).norm();
  const Eigen::Vector3f ray = (vertex - eye) / distance;
  const Eigen::Vector3f outward = (normal - normal.dot(ray) * ray).normalized();
  const Eigen::Vector3f beside = vertex + kOutside_px * static_cast<float>(distance / focal) * outward;
  return outward.allFinite() && !scene.occluded(Ray{eye, beside - eye});
}

void observe_rims(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, const RayScene& scene,
                  const PosedCamera& view, const ImageF& from_outline, double sigma_px, double reach_px,
                  Observations& observed) {
  const Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();
  const std::vector<bool> contour = on_contour(mesh, eye);
  const double focal = std::sqrt(view.camera.fx * view.camera.fy);
  const auto project = [&](const Eigen::Vector3f& point) {
    return view.camera.project(view.camera_from_object * point.cast<double>());
  };
  tbb::parallel_for(std::size_t{0}, mesh.vertices.size(), [&](std::size_t v) {
    if (!contour[v]) return;
    const Eigen::Vector3f& vertex = mesh.vertices[v];
    const float distance = (vertex - eye).norm();
    const auto footprint = static_cast<float>(distance / focal);
    if (!is_rim(vertex, normals[v], eye, focal, scene)) return;
    const auto pixel = project(vertex), moved = project(vertex + footprint * normals[v]);
    if (!pixel || !moved) return;
    const auto place = value_and_gradient(from_outline, *pixel);
    if (!place || std::abs((*place)[0]) > reach_px) return;
    // What a motion of one footprint along the normal changes in the distance from the outline, pixels.
    const double change = place->tail<2>().dot(*moved - *pixel);
    if (-change < kLeastLeverage) return;
    observed.add(static_cast<Eigen::Index>(v), -(*place)[0] / change * footprint,
                 std::pow(change / (sigma_px * footprint), 2));
  });
}

}  // namespace sheen
