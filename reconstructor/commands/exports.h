// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// Where a surface and its mean look go; empty: not asked for.
struct SurfaceFiles {
  std::filesystem::path gltf, ply, obj, usdz;
  bool empty() const { return gltf.empty() && ply.empty() && obj.empty() && usdz.empty(); }
};

/// What was written, for the report. `name`: of the model. Throws ConfigError where the model has no surface that is
/// seen from all sides, FileError where a file cannot be written.
nlohmann::json export_surface(const ModelSnapshot& model, const std::string& name, const SurfaceFiles& files);

/// A model as Gaussians for splat viewers, in a file of at most 5 MB. Throws ConfigError where it has no surface that
/// is seen from all sides, FileError.
nlohmann::json export_splats(const ModelSnapshot& model, const std::string& name, const std::filesystem::path& out);

/// An irradiance field of far lights as a polynomial texture map, or as a folder of the relight tools. Throws
/// ConfigError for any other model, FileError.
nlohmann::json export_relight(const ModelSnapshot& model, const std::string& name, const std::filesystem::path& out);

/// Where photographs with their cameras go, as data sets of other programs; empty: not asked for.
struct ImageSets {
  std::filesystem::path transforms, colmap;
  std::string mesh;  ///< whose vertices are the points that trainers begin with; empty: of the session's saved model
  bool undistort = false;
  bool empty() const { return transforms.empty() && colmap.empty(); }
};

/// `source`: a session, a data set or a list of lights. What was written, for the report. Throws ConfigError,
/// FileError, also where a folder is there already.
nlohmann::json export_images(const std::string& source, const ImageSets& sets);

}  // namespace sheen
