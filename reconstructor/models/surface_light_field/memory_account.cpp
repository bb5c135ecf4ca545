// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/memory_account.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/ring_model.h"
#include "reconstructor/surface/map_resolution.h"

namespace sheen {
namespace {

// A triangle in Embree: its corners' indices, its share of the vertices, and of the boxes (measured:
// memory_account_test).
constexpr double kRaySceneTriangle = 200;
constexpr double kRayScenes = 2;
// A surface sample of the current image: where it falls, whether it shows, its value, its step; and its mean colour.
constexpr double kIngestSample = 8 + 1 + 12 + 12 + 4;
// A pixel of the current image: ray, depth, safe depth, three bytes of edges; radiance and its coarser levels.
constexpr double kIngestPixel = 12 + 4 + 4 + 3 + 16 * 4 / 3.0;
constexpr double kImageCopies = 2;  // of an image: as the file has it, and decoded
constexpr double kSnapshots = 2;
constexpr double kFixedPerTriangle = 600;  // mesh, ray scene, rings, and what an image shows of them
constexpr int kFewTerms = 3, kFewColumns = 8;

}  // namespace

MemoryNeed memory_need(std::size_t vertices, std::size_t triangles, const SurfaceLightFieldOptions& options) {
  const double asked = options.map_scale * (options.surface_map > 0 ? options.surface_map : options.min_surface_map);
  const int side = std::max(2, static_cast<int>(std::lround(asked)));
  const auto v = static_cast<double>(vertices), t = static_cast<double>(triangles);
  const double samples = 3 * t * lattice_samples(side) / v;  // of a ring: a triangle is in three
  RingModelOptions few = options.ring;
  few.factor = few.factor.limited_to(kFewTerms, kFewTerms, kFewColumns);
  few.max_views = kFewColumns - few.factor.block;
  const double fixed = t * kFixedPerTriangle;
  return {fixed + v * RingModel::largest_bytes(samples, few),
          fixed + v * RingModel::largest_bytes(samples, options.ring)};
}

MemoryAccount fixed_account(const Mesh& mesh, const VertexRings& rings, const CaptureSize& image) {
  const auto vertices = static_cast<double>(mesh.vertices.size()),
             triangles = static_cast<double>(mesh.triangles.size()),
             samples = static_cast<double>(rings.total_samples());
  MemoryAccount account;
  account.mesh = vertices * (sizeof(Eigen::Vector3f) + sizeof(Eigen::Matrix3f)) + triangles * sizeof(Triangle) +
                 3 * triangles * (sizeof(RingTriangle) + sizeof(std::uint32_t)) + triangles * sizeof(std::size_t);
  account.ray_scene = kRayScenes * kRaySceneTriangle * triangles;
  account.ingest = kIngestSample * samples + kIngestPixel * image.pixels + kImageCopies * image.bytes;
  return account;
}

MemoryAccount largest_account(const Mesh& mesh, const Capture& first, const SurfaceLightFieldOptions& options) {
  const VertexRings rings(
      mesh, map_resolution(mesh, first.camera, first.pose.camera_from_object,
                           {options.surface_map, options.min_surface_map, options.max_surface_map, options.map_scale}));
  MemoryAccount account = fixed_account(mesh, rings, size_of(first));
  for (std::size_t v = 0; v < rings.size(); ++v) {
    if (rings.ring_samples(v) == 0) continue;
    account.model += RingModel::largest_bytes(rings.ring_samples(v), options.ring);
    account.snapshots += kSnapshots * RingModel::largest_snapshot_bytes(rings.ring_samples(v), options.ring);
  }
  return account;
}

}  // namespace sheen
