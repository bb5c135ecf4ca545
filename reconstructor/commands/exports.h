// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// Where a surface and its mean look go; empty: not asked for.
struct SurfaceFiles {
  std::filesystem::path gltf, ply, obj;
  bool empty() const { return gltf.empty() && ply.empty() && obj.empty(); }
};

/// What was written, for the report. `name`: of the model. Throws ConfigError where the model has no surface that is
/// seen from all sides, FileError where a file cannot be written.
nlohmann::json export_surface(const ModelSnapshot& model, const std::string& name, const SurfaceFiles& files);

/// An irradiance field of far lights as a polynomial texture map, or as a folder of the relight tools. Throws
/// ConfigError for any other model, FileError.
nlohmann::json export_relight(const ModelSnapshot& model, const std::string& name, const std::filesystem::path& out);

}  // namespace sheen
