// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "reconstructor/capture/live_mesh.h"

namespace sheen {

/// In a session's folder: the mesh that its model went over to.
inline constexpr const char* kRefinedMeshFile = "refined.ply";

/// Refines the mesh of a running capture. Each look begins at the mesh that was given, and the model goes over to the
/// new one only where images that were left out are predicted better than by the one it has (`refine_and_judge`). The
/// mesh that it went over to stands in the session's folder. `given`: as the user gave it; `present`: the one that the
/// model has. `on_finding`: told at the end (`over`), what is wrong with the given mesh as a whole. A look tells
/// {"gain_db", "standard_error_db", "mesh": "refined", "as before" or "given"}.
LookAtMesh refining_look(std::filesystem::path session_folder, std::shared_ptr<const Mesh> given,
                         std::shared_ptr<const Mesh> present, std::function<bool()> over,
                         std::function<void(const std::string&)> on_finding);

/// The mesh that a session's model went over to; null where it did to none. Throws FileError, also where it is not one
/// that the `given` mesh was refined to.
std::shared_ptr<const Mesh> refined_mesh_of(const std::filesystem::path& session_folder, const Mesh& given);

}  // namespace sheen
