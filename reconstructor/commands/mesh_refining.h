// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/capture/capture_set.h"
#include "reconstructor/refinement/mesh_refinement.h"

namespace sheen {

/// Refines a mesh against the captures that a model may be built from, judges it, and says on standard output what came
/// of it, with what is wrong with the mesh as a whole on standard error. The mesh as it was given where it did not
/// gain. `name`: of the mesh, for messages. `report`: what `refine --json` writes.
RefinedMesh refine_and_report(const CaptureSet& captures, const Mesh& mesh, const std::string& name, int hold_out_every,
                              nlohmann::json& report);

}  // namespace sheen
