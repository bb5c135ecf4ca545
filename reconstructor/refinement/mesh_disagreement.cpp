// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_disagreement.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "reconstructor/refinement/normal_sweep.h"
#include "reconstructor/refinement/sweep_minimum.h"
#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {
namespace {

constexpr std::size_t kMostVertices = 3000, kMostImages = 64;
constexpr double kSpacing_px = 2;  // between the points of a patch: displacements of up to 6 px are seen
constexpr int kSmoothing = 1;
constexpr double kClearance = 1.5;  // as a pass of `refine_mesh` at this spacing has it
constexpr double kPull = 0.004;
constexpr float kLeastAgreement = 0.5f;  // mean correlation of the images about a patch; else they show something else

/// Every nth, so that no more than `most` are left.
std::vector<std::size_t> spread(std::size_t all, std::size_t most) {
  std::vector<std::size_t> numbers;
  const std::size_t stride = std::max<std::size_t>(1, (all + most - 1) / most);
  for (std::size_t i = 0; i < all; i += stride) numbers.push_back(i);
  return numbers;
}

std::vector<float> edge_lengths(const Mesh& mesh, const MeshEdges& edges, const std::vector<std::uint32_t>& vertices) {
  std::vector<float> lengths;
  for (const std::uint32_t v : vertices) {
    float& mean = lengths.emplace_back(0);
    for (const std::uint32_t n : edges.around(v))
      mean += (mesh.vertices[n] - mesh.vertices[v]).norm() / static_cast<float>(edges.around(v).size());
  }
  return lengths;
}

std::size_t nearest_place(double at) {
  return static_cast<std::size_t>(kSweepReach + std::lround(at));
}

}  // namespace

MeshDisagreement measure_disagreement(const Mesh& mesh, const RefinementImages& images, const StepsDone& progress) {
  const std::vector<std::size_t> some = spread(images.cameras.size(), kMostImages);
  const RefinementImages looked_at = images.some(some);
  const MeshEdges edges(mesh);
  std::vector<std::uint32_t> vertices;
  Mesh points;
  for (const std::size_t v : spread(mesh.vertices.size(), kMostVertices)) {
    vertices.push_back(static_cast<std::uint32_t>(v));
    points.vertices.push_back(mesh.vertices[v]);
  }
  const std::vector<float> all_footprints = pixel_footprints(mesh, looked_at.cameras);
  const std::vector<float> lengths = edge_lengths(mesh, edges, vertices);
  std::vector<float> footprints, spacing;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    footprints.push_back(all_footprints[vertices[v]]);
    // A patch that is finer than the mesh shows what the mesh cannot follow.
    spacing.push_back(static_cast<float>(kSpacing_px) * std::max(footprints[v], lengths[v] / (kPatchSide - 1)));
  }
  const VertexPatches patches(mesh, edges, vertices, spacing, kSmoothing);
  NormalSweep sweep(points, patches, {}, kClearance);
  const RayScene scene(mesh);
  for (std::size_t i = 0; i < some.size(); ++i) {
    sweep.add(GreyPyramid(looked_at.read(i)), looked_at.cameras[i], scene);
    if (progress) progress(i + 1, some.size());
  }

  MeshDisagreement found{.looked_at = vertices.size()};
  double in_common = 0, here = 0, there = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const auto place = [&](NormalSweep::Part part) {
      return sweep_minimum(sweep.energy(v, part), sweep.images(v, part), 0, kPull);
    };
    const auto energy = [&](NormalSweep::Part part, double at) {
      return double(sweep.energy(v, part)[nearest_place(at)]);
    };
    if (sweep.images(v, NormalSweep::kFirst) < 2 || sweep.images(v, NormalSweep::kSecond) < 2) continue;
    ++found.seen;
    const auto both = place(NormalSweep::kBoth), first = place(NormalSweep::kFirst),
               second = place(NormalSweep::kSecond);
    if (!both || !first || !second) continue;
    if (sweep.agreement(v, static_cast<int>(nearest_place(both->place))) < kLeastAgreement) continue;
    ++found.observed;
    in_common += first->place * second->place * std::pow(spacing[v] / footprints[v], 2);
    here += energy(NormalSweep::kFirst, 0) + energy(NormalSweep::kSecond, 0);
    there += energy(NormalSweep::kFirst, second->place) + energy(NormalSweep::kSecond, first->place);
  }
  if (found.observed == 0) return found;
  found.off_px = std::sqrt(std::max(0.0, in_common / static_cast<double>(found.observed)));
  found.gain_db = 10 * std::log10(here / there);
  return found;
}

}  // namespace sheen
