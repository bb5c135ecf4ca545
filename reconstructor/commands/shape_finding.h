// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>

#include "reconstructor/shape/shape.h"

namespace sheen {

/// Finds a shape, with a progress bar, and tells on standard error what it is known from. `report`: the same in
/// figures.
FoundShape find_and_tell(const RefinementImages& images, const ShapeOptions& options, nlohmann::json& report);

/// PLY with `evidence` per vertex: 2 seen by images, 1 bounded by outlines, 0 guessed. Throws FileError.
void save_shape(const Mesh& mesh, std::span<const ShapeEvidence> evidence, const std::filesystem::path& path);

}  // namespace sheen
