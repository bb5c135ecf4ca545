// SPDX-License-Identifier: Apache-2.0
#include "common/registration/outline_evidence.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "common/registration/silhouette.h"

namespace sheen {
namespace {

constexpr float kOutside_px = 1.5f;     // where a ray beside an outline must pass without meeting anything
constexpr double kStep_px = 2;          // between points of a long edge
constexpr double kMaskOfObject = 3;     // a mask larger than this, of the silhouette's area, shows more than the object
constexpr double kSmallestMask = 0.05;  // smaller than this part of it: not this object's

std::size_t pixels_of(const ImageU8& mask) {
  return static_cast<std::size_t>(std::count_if(mask.data(), mask.data() + mask.size(), [](auto v) { return v != 0; }));
}

/// Value and gradient, bilinear; false within a pixel of the border.
bool value_and_gradient(const ImageF& image, const Eigen::Vector2d& at, double& value, Eigen::RowVector2d& gradient) {
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  if (x < 1 || y < 1 || x + 2 >= image.width() || y + 2 >= image.height()) return false;
  const double s = at.x() - x, t = at.y() - y;
  const auto mix = [&](int dx, int dy) {
    return (1 - t) * ((1 - s) * image.at(x + dx, y + dy) + s * image.at(x + dx + 1, y + dy)) +
           t * ((1 - s) * image.at(x + dx, y + dy + 1) + s * image.at(x + dx + 1, y + dy + 1));
  };
  value = mix(0, 0);
  const double left = (1 - t) * image.at(x, y) + t * image.at(x, y + 1);
  const double right = (1 - t) * image.at(x + 1, y) + t * image.at(x + 1, y + 1);
  const double above = (1 - s) * image.at(x, y) + s * image.at(x + 1, y);
  const double below = (1 - s) * image.at(x, y + 1) + s * image.at(x + 1, y + 1);
  gradient = {right - left, below - above};
  return true;
}

}  // namespace

std::vector<EdgeOfMesh> edges_of(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, EdgeOfMesh> found;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = mesh.triangles[t][c], b = mesh.triangles[t][(c + 1) % 3];
      const auto [it, fresh] = found.try_emplace(std::minmax(a, b), EdgeOfMesh{a, b, t});
      if (!fresh) it->second.right = t;
    }
  std::vector<EdgeOfMesh> edges;
  for (const auto& entry : found) edges.push_back(entry.second);
  return edges;
}

std::vector<OutlinePoint> outline_of(const Mesh& mesh, std::span<const EdgeOfMesh> edges, const RayScene& scene,
                                     const PosedCamera& camera_from_mesh) {
  const Eigen::Vector3f eye = camera_centre(camera_from_mesh.camera_from_object).cast<float>();
  const double focal = std::sqrt(camera_from_mesh.camera.fx * camera_from_mesh.camera.fy);
  std::vector<bool> front(mesh.triangles.size());
  for (std::size_t t = 0; t < front.size(); ++t) front[t] = mesh.area_normal(t).dot(eye - mesh.corner(t, 0)) > 0;

  std::vector<OutlinePoint> outline;
  for (const EdgeOfMesh& edge : edges) {
    if (edge.right != kNoHit && front[edge.left] == front[edge.right]) continue;
    const Eigen::Vector3f a = mesh.vertices[edge.from], b = mesh.vertices[edge.to];
    const Eigen::Vector3f middle = (a + b) / 2, ray = middle - eye;
    const float footprint = ray.norm() / static_cast<float>(focal);
    // Outward: across the edge and the ray, away from the third corner of the triangle on its left.
    Eigen::Vector3f outward = (b - a).cross(ray).normalized();
    const Eigen::Vector3f third =
        mesh.corner(edge.left, 0) + mesh.corner(edge.left, 1) + mesh.corner(edge.left, 2) - a - b;
    if (outward.dot(third - middle) > 0) outward = -outward;
    if (!outward.allFinite()) continue;
    const int pieces = std::clamp(static_cast<int>((b - a).norm() / (kStep_px * footprint)), 1, 1000);
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector3f point = a + (i + 0.5f) / static_cast<float>(pieces) * (b - a);
      if (scene.occluded(Ray{eye, point + kOutside_px * footprint * outward - eye})) continue;
      const auto pixel = camera_from_mesh.camera.project(camera_from_mesh.camera_from_object * point.cast<double>());
      if (pixel) outline.push_back({point, *pixel});
    }
  }
  return outline;
}

OutlineEvidence::OutlineEvidence(const Mesh& mesh, const RayScene& scene, std::span<const RegistrationImage> images,
                                 const Similarity& start)
    : mesh_(mesh), scene_(scene), images_(images), edges_(edges_of(mesh)), from_outline_(images.size()) {
  SilhouetteCaster caster;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].mask.empty()) continue;
    const auto shown = static_cast<double>(pixels_of(caster.cast(in_mesh_frame(images[i].view, start), mesh, scene)));
    const auto masked = static_cast<double>(pixels_of(images[i].mask));
    if (masked > kMaskOfObject * shown || masked < kSmallestMask * shown || masked == 0) continue;
    from_outline_[i] = distance_from_outline(images[i].mask);
    ++masks_;
  }
}

std::vector<ImageEquations> OutlineEvidence::equations(const Similarity& stage_from_mesh, const Eigen::Vector3d& centre,
                                                       double loss_px, Half half) const {
  std::vector<ImageEquations> result(images_.size());
  tbb::parallel_for(std::size_t{0}, images_.size(), [&](std::size_t i) {
    if (from_outline_[i].empty() || !in_half(i, half)) return;
    const PosedCamera& view = images_[i].view;
    for (const OutlinePoint& at : outline_of(mesh_, edges_, scene_, in_mesh_frame(view, stage_from_mesh))) {
      double distance;
      Eigen::RowVector2d gradient;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> by_point;
      const Eigen::Vector3d stage_point = stage_from_mesh * at.point.cast<double>();
      if (!project_with_derivative(view, stage_point, pixel, by_point)) continue;
      if (!value_and_gradient(from_outline_[i], pixel, distance, gradient)) continue;
      const double squared = std::pow(distance / loss_px, 2);
      const Eigen::Matrix<double, 1, 7> row = gradient * by_point * point_derivative(stage_point, centre);
      result[i].add<1>(1 / (1 + squared), row, Eigen::Matrix<double, 1, 1>(distance));
      result[i].loss += loss_px * loss_px * std::log1p(squared);
      result[i].scale += 1;
    }
  });
  return result;
}

std::vector<double> OutlineEvidence::distances(const Similarity& stage_from_mesh) const {
  std::vector<double> all;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    if (from_outline_[i].empty()) continue;
    for (const OutlinePoint& at : outline_of(mesh_, edges_, scene_, in_mesh_frame(images_[i].view, stage_from_mesh))) {
      double distance;
      Eigen::RowVector2d gradient;
      if (value_and_gradient(from_outline_[i], at.pixel, distance, gradient)) all.push_back(distance);
    }
  }
  return all;
}

}  // namespace sheen
