// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "common/geometry/mesh.h"
#include "reconstructor/models/model_settings.h"
#include "reconstructor/scene/mesh_scale.h"

namespace sheen {

/// Loads a mesh and tells on standard error its size, what is wrong with it, that a model with these settings may not
/// fit into the memory, and that the cameras cannot see it. Throws FileError, also where it can only be of another unit
/// or where no model of it fits.
Mesh load_mesh_and_warn(const std::filesystem::path& path, const ModelSettings& settings,
                        std::span<const PosedCamera> cameras);

/// What a model with these settings models the surface of: the scene's mesh, or what the model makes itself of what the
/// first camera sees. `mesh`: as the user gave it, empty where there is none. Throws ConfigError naming --mesh where
/// the model needs one or takes none, or where the cameras stand too far from the origin of their frame for a model
/// that makes its own, and what loading a mesh throws.
Mesh surface_for(const ModelSettings& settings, const std::string& mesh, std::span<const PosedCamera> cameras);

/// Whether `surface_for` waits for a camera.
bool surface_needs_camera(const ModelSettings& settings, const std::string& mesh);

}  // namespace sheen
