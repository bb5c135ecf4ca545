// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "common/geometry/mesh.h"
#include "reconstructor/capture/capture_set.h"

namespace sheen {

class Command;

/// `--object-size`: what a person has measured of an object that is captured by photographs alone.
struct ObjectSizeArgument {
  std::string word;

  void add_to(Command& command);
  /// Metres, where it is given. Throws ConfigError.
  std::optional<double> metres() const;
};

/// The data set to read: `folder` itself, or where it has photographs alone the one of the poses that are found for
/// them, which is told on standard error. `report`: the same, where it is so. Throws what `pose_photographs` throws,
/// and ConfigError for a size that does not belong to photographs alone, or a mesh that cannot.
std::string with_poses(const std::string& folder, const ObjectSizeArgument& size, const std::string& mesh,
                       nlohmann::json& report);

/// Scales a shape that was found, and the data set of `with_poses` with it, so that the greatest length between two of
/// its points is `metres`; `captures` are those of the data set anew. `report`: of the shape.
void bring_to_size(double metres, const std::string& dataset, Mesh& shape, CaptureSet& captures,
                   nlohmann::json& report);

}  // namespace sheen
