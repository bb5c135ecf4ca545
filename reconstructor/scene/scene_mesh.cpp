// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/scene/scene_mesh.h"

#include <cstdio>
#include <string>
#include <utility>

#include "reconstructor/scene/memory_warning.h"

namespace sheen {

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

}  // namespace sheen
