// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/normal_sweep.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "common/base/order_statistics.h"

namespace sheen {
namespace {

constexpr float kLeastCosine = 0.3f;  // of the view with the normal: flatter patches show little and are hidden early
constexpr float kRimMargin = 1.5f;  // patches by which what surrounds one must be seen, too: silhouettes are no texture
constexpr float kContrastFloor = 0.012f;  // standard deviation of grey, of 1: three levels of 255 are noise

using Patch = Eigen::Array<float, kPatchPoints, 1>;

/// Where a vertex at each place falls in an image, and how pixels change with the point.
struct Projection {
  std::array<Eigen::Vector2f, kSweepPlaces> pixel;
  Eigen::Matrix<float, 2, 3> pixel_from_offset;
};

std::optional<Projection> project(const PosedCamera& view, const Eigen::Vector3f& vertex, const Eigen::Vector3f& normal,
                                  float spacing) {
  Projection projection;
  const auto at = [&](const Eigen::Vector3f& point) {
    return view.camera.project(view.camera_from_object * point.cast<double>());
  };
  for (int k = 0; k < kSweepPlaces; ++k) {
    const auto pixel = at(vertex + static_cast<float>(k - kSweepReach) * spacing * normal);
    if (!pixel) return {};
    projection.pixel[k] = pixel->cast<float>();
  }
  const Eigen::Vector2f middle = projection.pixel[kSweepReach];
  for (int axis = 0; axis < 3; ++axis) {
    const auto pixel = at(vertex + spacing * Eigen::Vector3f::Unit(axis));
    if (!pixel) return {};
    projection.pixel_from_offset.col(axis) = (pixel->cast<float>() - middle) / spacing;
  }
  return projection;
}

/// Whether the ray to a point of a patch meets the surface near it: nothing hides it, and it lies within the
/// silhouette.
bool meets_surface(const RayScene& scene, const Eigen::Vector3f& point, const Eigen::Vector3f& eye, float clearance) {
  const Eigen::Vector3f direction = (point - eye).normalized();
  const Hit hit = scene.intersect(Ray{eye, direction});
  return hit && hit.front && std::abs(hit.distance - (point - eye).norm()) < clearance;
}

/// The patch less its mean, over its contrast. Its squared norm is below 1, and small where it shows noise only.
bool normalise(Patch& patch) {
  const float mean = patch.mean();
  if (!std::isfinite(mean)) return false;
  patch -= mean;
  const float variance = patch.square().mean();
  patch /= std::sqrt(kPatchPoints * (variance + kContrastFloor * kContrastFloor));
  return true;
}

/// 1 where an image shows what is expected, 1/2 where it is as far from it as images are in the mean.
float trust(const Patch& seen, const ExpectedPatch& expected) {
  if (!(expected.energy > 0)) return 1;
  const float squared = (seen - Eigen::Map<const Patch>(expected.values.data())).square().sum();
  return 1 / (1 + squared / expected.energy);
}

}  // namespace

std::vector<ViewSplit> split_views(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals,
                                   std::span<const PosedCamera> cameras) {
  std::vector<Eigen::Vector3f> eyes;
  for (const PosedCamera& camera : cameras) eyes.push_back(camera_centre(camera.camera_from_object).cast<float>());
  std::vector<ViewSplit> splits(mesh.vertices.size());
  tbb::parallel_for(std::size_t{0}, splits.size(), [&](std::size_t v) {
    const Eigen::Vector3f s = normals[v].unitOrthogonal(), t = normals[v].cross(s);
    std::vector<Eigen::Vector2f> facing;
    Eigen::Vector2f mean = Eigen::Vector2f::Zero();
    for (const Eigen::Vector3f& eye : eyes) {
      const Eigen::Vector3f to_eye = (eye - mesh.vertices[v]).normalized();
      if (normals[v].dot(to_eye) < kLeastCosine) continue;
      facing.emplace_back(s.dot(to_eye), t.dot(to_eye));
      mean += facing.back();
    }
    if (facing.size() < 2) return;
    mean /= static_cast<float>(facing.size());
    Eigen::Matrix2f spread = Eigen::Matrix2f::Zero();
    for (const Eigen::Vector2f& f : facing) spread += (f - mean) * (f - mean).transpose();
    const Eigen::Vector2f axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f>(spread).eigenvectors().col(1);
    std::vector<float> along;
    for (const Eigen::Vector2f& f : facing) along.push_back(axis.dot(f));
    splits[v] = {axis.x() * s + axis.y() * t, median(along)};
  });
  return splits;
}

NormalSweep::NormalSweep(const Mesh& mesh, const VertexPatches& patches, std::span<const ViewSplit> splits,
                         double clearance, std::span<const ExpectedPatch> expected)
    : mesh_(mesh), patches_(patches), splits_(splits), clearance_(static_cast<float>(clearance)), expected_(expected) {
  for (auto& half : halves_) half.resize(mesh.vertices.size());
}

void NormalSweep::add(const GreyPyramid& image, const PosedCamera& view, const RayScene& scene) {
  const Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();
  const auto look = [&](std::size_t v) {
    const Eigen::Vector3f& vertex = mesh_.vertices[v];
    const Eigen::Vector3f& normal = patches_.normals[v];
    const float spacing = patches_.spacing[v];
    const float cosine = normal.dot((eye - vertex).normalized());
    if (cosine < kLeastCosine) return;
    const auto offsets = patches_.of(v);
    const auto projection = project(view, vertex, normal, spacing);
    if (!projection) return;
    for (const int probe : kPatchProbes)
      if (!meets_surface(scene, vertex + kRimMargin * offsets[probe], eye, clearance_ * spacing / cosine)) return;
    const Eigen::Map<const Eigen::Matrix<float, 3, kPatchPoints>> points(offsets.front().data());
    const Eigen::Matrix<float, 2, kPatchPoints> in_image = projection->pixel_from_offset * points;
    const float step_px = std::sqrt((in_image.col(kPatchSide - 1) - in_image.col(0)).norm() *
                                    (in_image.col(kPatchPoints - kPatchSide) - in_image.col(0)).norm()) /
                          (kPatchSide - 1);
    const int level = image.level_for(step_px);
    std::array<Patch, kSweepPlaces> seen;
    for (int k = 0; k < kSweepPlaces; ++k) {
      for (int s = 0; s < kPatchPoints; ++s)
        seen[k][s] =
            image.sample(level, projection->pixel[k].x() + in_image(0, s), projection->pixel[k].y() + in_image(1, s));
      if (!normalise(seen[k])) return;
    }
    Sums& sums = halves_[splits_.empty() ? images_ % 2 : splits_[v].half((eye - vertex).normalized())][v];
    const float weight = cosine * (expected_.empty() ? 1 : trust(seen[kSweepReach], expected_[v]));
    sums.weight += weight;
    ++sums.images;
    for (int k = 0; k < kSweepPlaces; ++k) {
      sums.squares[k] += weight * seen[k].matrix().squaredNorm();
      Eigen::Map<Patch>(sums.patch[k].data()) += weight * seen[k];
    }
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mesh_.vertices.size(), 64), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) look(v);
  });
  ++images_;
}

NormalSweep::Energy NormalSweep::energy(std::size_t vertex, Part part) const {
  Energy energy{};
  float weight = 0;
  for (int half = 0; half < 2; ++half)
    if (part == kBoth || part == half) weight += halves_[half][vertex].weight;
  if (weight == 0) return energy;
  for (int k = 0; k < kSweepPlaces; ++k) {
    float squares = 0;
    Patch sum = Patch::Zero();
    for (int half = 0; half < 2; ++half)
      if (part == kBoth || part == half) {
        squares += halves_[half][vertex].squares[k];
        sum += Eigen::Map<const Patch>(halves_[half][vertex].patch[k].data());
      }
    energy[k] = (squares - sum.matrix().squaredNorm() / weight) / weight;
  }
  return energy;
}

float NormalSweep::agreement(std::size_t vertex, int place) const {
  const Sums &a = halves_[0][vertex], &b = halves_[1][vertex];
  const float squares = a.squares[place] + b.squares[place];
  if (!(squares > 0)) return 0;
  return 1 - energy(vertex, kBoth)[place] * (a.weight + b.weight) / squares;
}

ExpectedPatch NormalSweep::expected(std::size_t vertex, int place) const {
  const Sums &a = halves_[0][vertex], &b = halves_[1][vertex];
  ExpectedPatch expected;
  const float weight = a.weight + b.weight;
  if (!(weight > 0)) return expected;
  for (int s = 0; s < kPatchPoints; ++s) expected.values[s] = (a.patch[place][s] + b.patch[place][s]) / weight;
  expected.energy = energy(vertex, kBoth)[place];
  return expected;
}

int NormalSweep::images(std::size_t vertex, Part part) const {
  int images = 0;
  for (int half = 0; half < 2; ++half)
    if (part == kBoth || part == half) images += halves_[half][vertex].images;
  return images;
}

}  // namespace sheen
