// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "common/base/command_line.h"
#include "reconstructor/shape/shape.h"

namespace sheen {

/// --from-mesh: a mesh that is about the object (`RoughShape`).
Option add_rough_mesh_option(Command& command, std::string& path);
/// Nothing where the option was not given. Throws FileError.
std::optional<Mesh> rough_mesh(const std::string& path);

/// Finds a shape, with a progress bar, and tells on standard error what it is known from. `report`: the same in
/// figures.
FoundShape find_and_tell(const RefinementImages& images, const ShapeOptions& options, nlohmann::json& report);

}  // namespace sheen
