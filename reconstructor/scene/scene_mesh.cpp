// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/scene_mesh.h"

#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>

#include "common/base/errors.h"
#include "common/base/format.h"
#include "reconstructor/scene/memory_warning.h"

namespace sheen {
namespace {

/// What makes its own surface takes the object to stand at the origin of the poses' frame.
void check_origin_can_be_seen(std::span<const PosedCamera> cameras) {
  constexpr double kFarthest = 1e4;  // of the cameras' distance from each other: from there all see the same
  constexpr double kStill = 1e-10;   // of their distance from the origin: one camera, but for rounding
  double apart = 0;
  const Eigen::Vector3d first = camera_centre(cameras.front().camera_from_object);
  for (const PosedCamera& camera : cameras)
    apart = std::max(apart, (camera_centre(camera.camera_from_object) - first).norm());
  if (!(apart > kStill * first.norm() && first.norm() > kFarthest * apart)) return;
  throw ConfigError(
      format("without --mesh the object is taken to stand at the origin of the poses' frame, which is "
             "%.4g km from the cameras: give --mesh, or move the frame",
             first.norm() / 1e3));
}

}  // namespace

Mesh load_mesh_and_warn(const std::filesystem::path& path, const ModelSettings& settings,
                        std::span<const PosedCamera> cameras) {
  LoadedMesh loaded = load_mesh(path);
  const MeshDiagnosis& found = loaded.diagnosis;
  std::fprintf(stderr, "%s: %zu triangles, %s\n", path.c_str(), found.triangles, size_text(loaded.mesh).c_str());
  for (const std::string& warning : found.warnings()) std::fprintf(stderr, "%s: %s\n", path.c_str(), warning.c_str());
  const MemoryNeed need = settings.memory_need(found.vertices, found.triangles);
  const std::string memory = memory_warning(path, found.triangles, need, machine_memory());
  if (!memory.empty()) std::fprintf(stderr, "%s\n", memory.c_str());
  check_scale(path, loaded.mesh, cameras);
  return std::move(loaded.mesh);
}

bool surface_needs_camera(const ModelSettings& settings, const std::string& mesh) {
  return settings.makes_mesh() && (mesh.empty() || !settings.takes_mesh());
}

Mesh surface_for(const ModelSettings& settings, const std::string& mesh, std::span<const PosedCamera> cameras) {
  if (surface_needs_camera(settings, mesh)) {
    if (!mesh.empty())
      throw ConfigError(std::string("--mesh: ") + settings.kind() + " makes its own surface; leave it out");
    if (!cameras.empty()) check_origin_can_be_seen(cameras);
    if (std::optional<Mesh> own = cameras.empty() ? std::nullopt : settings.own_mesh(cameras.front())) return *own;
  }
  if (mesh.empty())
    throw ConfigError(std::string("--mesh is required: ") + settings.kind() +
                      " models the surface of a mesh (--model irradiance-field needs none, but a list of lights)");
  return load_mesh_and_warn(mesh, settings, cameras);
}

}  // namespace sheen
