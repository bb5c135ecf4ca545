// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/memory_account.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/models/surface_light_field/map_detail.h"
#include "reconstructor/models/surface_light_field/patch_model.h"
#include "reconstructor/surface/map_resolution.h"

namespace sheen {
namespace {

// A triangle in Embree: its corners' indices, its share of the vertices, and of the boxes (measured:
// memory_account_test).
constexpr double kRaySceneTriangle = 200;
// A triangle elsewhere: its patch, and where images show it.
constexpr double kIngestTriangle = 300;
// A surface sample: whether the current image shows it; its mean colour.
constexpr double kIngestSample = 1 + 8;
// A pixel of the current image: safe depth, three bytes of edges; radiance and its coarser levels. Its ray, if the lens
// bends it.
constexpr double kIngestPixel = 4 + 3 + 16 * 4 / 3.0, kBentRay = 8;
constexpr double kImageCopies = 2;  // of an image: as the file has it, and decoded
constexpr double kSnapshots = 2;
constexpr double kFixedPerTriangle = 600;  // mesh, ray scene, and what an image shows of them
constexpr int kFewTerms = 3, kFewColumns = 8;

/// Of triangles in which no image shows chroma as fine as luma.
int chroma_side(int side, const SurfaceLightFieldOptions& options) {
  return options.coarse_chroma() ? half_side(side) : side;
}

}  // namespace

MemoryNeed memory_need(std::size_t triangles, const SurfaceLightFieldOptions& options) {
  const double asked = options.map_scale * (options.surface_map > 0 ? options.surface_map : options.min_surface_map);
  const int side = std::max(2, static_cast<int>(std::lround(asked)));
  const auto t = static_cast<double>(triangles);
  const PatchSize& size = options.patch.size;
  const auto of_triangle = static_cast<std::size_t>(lattice_samples(side));
  const auto of_patch = static_cast<double>(std::max(size.triangles, (size.samples + of_triangle - 1) / of_triangle));
  const double patches = t / of_patch;
  const PatchModel::Counts patch{of_patch * static_cast<double>(of_triangle),
                                 of_patch * lattice_samples(chroma_side(side, options)), of_patch + 2};
  PatchModelOptions few = options.patch;
  few.factor = few.factor.limited_to(kFewTerms, kFewTerms, kFewColumns);
  few.max_views = kFewColumns - few.factor.block;
  const double fixed = t * kFixedPerTriangle;
  return {fixed + patches * PatchModel::largest_bytes(patch, few),
          fixed + patches * PatchModel::largest_bytes(patch, options.patch)};
}

MemoryAccount fixed_account(const Mesh& mesh, const MapLayout& maps, const CaptureSize& image) {
  const auto vertices = static_cast<double>(mesh.vertices.size()),
             triangles = static_cast<double>(mesh.triangles.size()),
             samples = static_cast<double>(maps.total_samples());
  MemoryAccount account;
  account.mesh = vertices * (sizeof(Eigen::Vector3f) + sizeof(Eigen::Matrix3f)) + triangles * sizeof(Triangle) +
                 static_cast<double>(maps.bytes());
  account.ray_scene = kRaySceneTriangle * triangles;
  account.ingest = kIngestTriangle * triangles + kIngestSample * samples + kIngestPixel * image.pixels +
                   (image.lens_bends ? kBentRay * image.pixels : 0) + kImageCopies * image.bytes;
  return account;
}

MemoryAccount largest_account(const Mesh& mesh, const Capture& first, const SurfaceLightFieldOptions& options) {
  const MapLayout maps(
      map_resolution(mesh, first.camera, first.pose.camera_from_object,
                     {options.surface_map, options.min_surface_map, options.max_surface_map, options.map_scale}));
  MemoryAccount account = fixed_account(mesh, maps, size_of(first));
  const PatchShapes shapes = cut_into_patches(mesh, maps, options.patch.size);
  for (const PatchShape& shape : shapes.patches) {
    PatchModel::Counts patch{static_cast<double>(shape.samples), 0, static_cast<double>(shape.vertices.size())};
    for (const std::uint32_t t : shape.triangles)
      patch.chroma_samples += lattice_samples(chroma_side(maps.resolution(t), options));
    account.model += PatchModel::largest_bytes(patch, options.patch);
    account.snapshots += kSnapshots * PatchModel::largest_snapshot_bytes(patch, options.patch);
  }
  return account;
}

}  // namespace sheen
