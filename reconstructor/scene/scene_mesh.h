// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

#include "common/geometry/mesh.h"
#include "reconstructor/models/model_settings.h"
#include "reconstructor/scene/mesh_scale.h"

namespace sheen {

/// Loads a mesh and tells on standard error its size, what is wrong with it, that a model with these settings may not
/// fit into the memory, and that the cameras cannot see it. Throws FileError, also where it can only be of another unit
/// or where no model of it fits.
Mesh load_mesh_and_warn(const std::filesystem::path& path, const ModelSettings& settings,
                        std::span<const PosedCamera> cameras);

}  // namespace sheen
