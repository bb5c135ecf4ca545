// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/normal_sweep.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "common/base/order_statistics.h"
#include "reconstructor/refinement/patch_view.h"

namespace sheen {
namespace {

/// Where a vertex at each place falls in an image; empty where it falls outside.
using Places = std::array<Eigen::Vector2f, kSweepPlaces>;
std::optional<Places> project_places(const PosedCamera& view, const Eigen::Vector3f& vertex,
                                     const Eigen::Vector3f& normal, float spacing) {
  Places places;
  for (int k = 0; k < kSweepPlaces; ++k) {
    const Eigen::Vector3f point = vertex + static_cast<float>(k - kSweepReach) * spacing * normal;
    const auto pixel = view.camera.project(view.camera_from_object * point.cast<double>());
    if (!pixel) return {};
    places[k] = pixel->cast<float>();
  }
  return places;
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
    const auto patch = view_patch(view, vertex, patches_, v, image, scene, clearance_);
    if (!patch) return;
    const auto places = project_places(view, vertex, patches_.normals[v], patches_.spacing[v]);
    if (!places) return;
    std::array<Patch, kSweepPlaces> seen;
    for (int k = 0; k < kSweepPlaces; ++k) {
      const auto at_place = patch->sample(image, (*places)[k]);
      if (!at_place) return;
      seen[k] = *at_place;
    }
    Sums& sums = halves_[splits_.empty() ? images_ % 2 : splits_[v].half((eye - vertex).normalized())][v];
    const float weight = patch->cosine * (expected_.empty() ? 1 : trust(seen[kSweepReach], expected_[v]));
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
