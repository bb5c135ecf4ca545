// SPDX-License-Identifier: Apache-2.0
#include "common/registration/texture_evidence.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/registration/silhouette.h"

namespace sheen {
namespace {

constexpr std::size_t kPoints = 4000, kPart = 256;
constexpr float kLeastCosine = 0.35f;
constexpr float kClearance = 2e-3f;  // of the distance: what a ray to a point may miss it by
constexpr double kLoss =
    1;  // of the detail, whose standard deviation is about 1: residuals beyond it lose their weight
constexpr double kNarrowest_px = 25;  // of the mesh, at the coarsest level

}  // namespace

TextureEvidence::TextureEvidence(const Mesh& mesh, const RayScene& scene, std::span<const RegistrationImage> images,
                                 int finest)
    : mesh_(mesh), scene_(scene), images_(images), level_(finest) {
  for (const RegistrationImage& image : images) pyramids_.emplace_back(image.grey, finest);
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += mesh.area_normal(t).norm();
  const double each = area / static_cast<double>(kPoints);
  double due = each / 2;
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3f normal = mesh.area_normal(t);
    for (due -= normal.norm(); due < 0; due += each) {
      // Places in the triangle by the R2 sequence, folded back into it.
      ++count;
      float u = static_cast<float>(std::fmod(0.7548776662466927 * static_cast<double>(count), 1.0));
      float v = static_cast<float>(std::fmod(0.5698402909980532 * static_cast<double>(count), 1.0));
      if (u + v > 1) u = 1 - u, v = 1 - v;
      points_.push_back((1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2));
      normals_.push_back(normal.normalized());
    }
  }
  seen_.resize(points_.size());
}

int TextureEvidence::coarsest(const Similarity& stage_from_mesh) const {
  const BoundingSphere sphere = bounding_sphere(mesh_);
  double widest_px = 0;
  int levels = 1;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const PosedCamera view = in_mesh_frame(images_[i].view, stage_from_mesh);
    const double distance = (view.camera_from_object * sphere.centre).norm();
    widest_px = std::max(widest_px, 2 * sphere.radius / distance * std::sqrt(view.camera.fx * view.camera.fy));
    levels = std::max(levels, pyramids_[i].levels());
  }
  int level = 0;
  while (level + 1 < levels && widest_px / (2 << level) > kNarrowest_px) ++level;
  return level;
}

void TextureEvidence::see(const Similarity& stage_from_mesh, int level, double margin_px) {
  level_ = level;
  for (auto& sights : seen_) sights.clear();
  SilhouetteCaster caster;
  for (std::uint32_t i = 0; i < images_.size(); ++i) {
    const PosedCamera full = in_mesh_frame(images_[i].view, stage_from_mesh);
    const auto on_level = [level](int side) { return std::max(1, side >> level); };
    const PosedCamera view{full.camera.scaled(on_level(full.camera.width), on_level(full.camera.height)),
                           full.camera_from_object};
    const Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();
    const ImageF inside = distance_from_outline(caster.cast(view, mesh_, scene_));
    const auto least_inside = static_cast<float>(margin_px);
    std::vector<float> cosines(points_.size(), 0);
    tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t k) {
      const Eigen::Vector3f to_eye = eye - points_[k];
      const float cosine = to_eye.normalized().dot(normals_[k]);
      if (cosine < kLeastCosine) return;
      const auto pixel = view.camera.project(view.camera_from_object * points_[k].cast<double>());
      if (!pixel || !view.camera.contains(*pixel, 1)) return;
      if (inside.at(static_cast<int>(pixel->x() + 0.5), static_cast<int>(pixel->y() + 0.5)) < least_inside) return;
      if (scene_.occluded(Ray{points_[k], to_eye, kClearance, 1})) return;
      cosines[k] = cosine;
    });
    for (std::size_t k = 0; k < points_.size(); ++k)
      if (cosines[k] > 0) seen_[k].push_back({i, cosines[k]});
  }
}

std::vector<ImageEquations> TextureEvidence::equations(const Similarity& stage_from_mesh, const Eigen::Vector3d& centre,
                                                       Half half) const {
  using Row = Eigen::Matrix<double, 1, 7>;
  struct Shown {
    std::uint32_t image;
    double weight, value;
    Row by_step;
  };
  const auto add_point = [&](std::size_t k, std::vector<ImageEquations>& equations) {
    const Eigen::Vector3d stage_point = stage_from_mesh * points_[k].cast<double>();
    const Eigen::Matrix<double, 3, 7> by_step = point_derivative(stage_point, centre);
    std::vector<Shown> shown;
    for (const Sight& sight : seen_[k]) {
      if (!in_half(sight.image, half)) continue;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> by_point;
      float value;
      Eigen::Vector2f gradient;
      if (!project_with_derivative(images_[sight.image].view, stage_point, pixel, by_point)) continue;
      if (!pyramids_[sight.image].sample(level_, pixel.x(), pixel.y(), value, gradient)) continue;
      shown.push_back({sight.image, sight.weight, value, gradient.cast<double>().transpose() * by_point * by_step});
    }
    if (shown.size() < 2) return;
    // The mean twice: first of all images, then of those that are near it.
    double mean = 0;
    Row mean_row;
    for (int round = 0; round < 2; ++round) {
      double total = 0, sum = 0;
      mean_row.setZero();
      for (const Shown& s : shown) {
        const double w = round == 0 ? s.weight : s.weight / (1 + std::pow((s.value - mean) / kLoss, 2));
        total += w;
        sum += w * s.value;
        mean_row += w * s.by_step;
      }
      mean = sum / total;
      mean_row /= total;
    }
    for (const Shown& s : shown) {
      const double r = s.value - mean, squared = std::pow(r / kLoss, 2);
      equations[s.image].add<1>(s.weight / (1 + squared), s.by_step - mean_row, Eigen::Matrix<double, 1, 1>(r));
      equations[s.image].loss += s.weight * std::log1p(squared);
      const double alone = std::pow(s.value / kLoss, 2);
      equations[s.image].scale += s.weight * std::log1p(alone);
      equations[s.image].scale_gradient += s.weight / (1 + alone) * s.value * s.by_step.transpose();
    }
  };
  // In parts of a fixed size that are added in their order: the same bits on any number of threads.
  std::vector<std::vector<ImageEquations>> parts((points_.size() + kPart - 1) / kPart);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t p) {
    parts[p].resize(images_.size());
    for (std::size_t k = p * kPart; k < std::min(points_.size(), (p + 1) * kPart); ++k) add_point(k, parts[p]);
  });
  std::vector<ImageEquations> result(images_.size());
  for (const std::vector<ImageEquations>& part : parts)
    for (std::size_t i = 0; i < result.size(); ++i) result[i] += part[i];
  return result;
}

TextureEvidence::Agreement TextureEvidence::agreement(const Similarity& stage_from_mesh) const {
  // Of all pairs of images about a point: (sum of values)^2 - sum of squares = sum over pairs of their products.
  double products = 0, squares = 0;
  Agreement found;
  for (std::size_t k = 0; k < points_.size(); ++k) {
    const Eigen::Vector3d stage_point = stage_from_mesh * points_[k].cast<double>();
    double sum = 0, square = 0, n = 0;
    for (const Sight& sight : seen_[k]) {
      const PosedCamera& view = images_[sight.image].view;
      const auto pixel = view.camera.project(view.camera_from_object * stage_point);
      float value;
      Eigen::Vector2f gradient;
      if (!pixel || !pyramids_[sight.image].sample(level_, pixel->x(), pixel->y(), value, gradient)) continue;
      sum += value;
      square += double(value) * value;
      ++n;
    }
    if (n < 2) continue;
    products += (sum * sum - square) / (n - 1);
    squares += square;
    ++found.points;
  }
  found.correlation = squares > 0 ? products / squares : 0;
  return found;
}

}  // namespace sheen
