// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/effort/memory_account.h"

#include <fstream>

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

}  // namespace

std::map<std::string, double> MemoryAccount::parts() const {
  return {{"mesh", mesh},           {"ray_scene", ray_scene}, {"ingest", ingest}, {"rings", rings},
          {"snapshots", snapshots}, {"held_out", held_out},   {"probe", probe}};
}

CaptureSize size_of(const Capture& capture) {
  return {static_cast<double>(capture.image.width) * capture.image.height,
          static_cast<double>(capture.image.bytes.size() + capture.mask.size())};
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
    account.rings += RingModel::largest_bytes(rings.ring_samples(v), options.ring);
    account.snapshots += kSnapshots * RingModel::largest_snapshot_bytes(rings.ring_samples(v), options.ring);
  }
  return account;
}

ResidentMemory resident_memory() {
  ResidentMemory memory;
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key; status.ignore(1 << 10, '\n')) {
    double kilobytes = 0;
    if (key == "VmRSS:" && status >> kilobytes) memory.bytes = 1024 * kilobytes;
    if (key == "VmHWM:" && status >> kilobytes) memory.peak_bytes = 1024 * kilobytes;
  }
  return memory;
}

}  // namespace sheen
