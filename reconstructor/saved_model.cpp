// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/saved_model.h"

#include <cstdio>
#include <sstream>

#include "reconstructor/exchange/model_files.h"
#include "reconstructor/memory_need.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"

namespace sheen {
namespace {

constexpr const char* kHeldOutKey = "held_out";  // names, a line each

}  // namespace

Mesh load_mesh_and_warn(const std::filesystem::path& path, const SurfaceLightFieldOptions& options,
                        std::span<const PosedCamera> cameras) {
  LoadedMesh loaded = load_mesh(path);
  const MeshDiagnosis& found = loaded.diagnosis;
  std::fprintf(stderr, "%s: %zu triangles, %s\n", path.c_str(), found.triangles, size_text(loaded.mesh).c_str());
  for (const std::string& warning : found.warnings()) std::fprintf(stderr, "%s: %s\n", path.c_str(), warning.c_str());
  const std::string memory = memory_warning(path, found.vertices, found.triangles, options, machine_memory());
  if (!memory.empty()) std::fprintf(stderr, "%s\n", memory.c_str());
  check_scale(path, loaded.mesh, cameras);
  return std::move(loaded.mesh);
}

void save_reconstruction(Reconstruction& reconstruction, const std::filesystem::path& folder, const std::string& source,
                         const StepsDone& progress) {
  std::string names;
  for (const HeldOutView& view : reconstruction.held_out()) names += view.name + "\n";
  save_model(*fill_unseen(*reconstruction.snapshot()), folder,
             {{"source", source}, {"images", std::to_string(reconstruction.counts().accepted)}, {kHeldOutKey, names}},
             {.progress = progress});
}

std::set<std::string> held_out_names(const std::filesystem::path& model_folder) {
  std::set<std::string> names;
  const ModelMetadata metadata = load_model_metadata(model_folder);
  if (const auto found = metadata.find(kHeldOutKey); found != metadata.end()) {
    std::istringstream lines(found->second);
    for (std::string line; std::getline(lines, line);) names.insert(line);
  }
  return names;
}

}  // namespace sheen
