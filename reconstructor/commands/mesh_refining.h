// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/refinement/mesh_judgement.h"

namespace sheen {

/// Refines a mesh, judges it, and says on standard output what came of it. `report`: what `refine --json` writes of it.
/// Throws Error where it is to stop before it is done.
JudgedMesh refine_and_print(const Mesh& mesh, const RefinementImages& images, nlohmann::json& report);

/// The mesh as it was given where it did not gain.
RefinedMesh kept_mesh(const Mesh& given, const JudgedMesh& judged);

/// Says on standard error what is wrong with a mesh as a whole. `name`: of the mesh, for messages.
void report_findings(const Mesh& given, const std::string& name, const JudgedMesh& judged,
                     const RefinementImages& images, nlohmann::json& report);

}  // namespace sheen
