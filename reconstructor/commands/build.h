// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "reconstructor/commands/favour_option.h"
#include "reconstructor/commands/limit_options.h"
#include "reconstructor/commands/photograph_poses.h"
#include "reconstructor/commands/size_options.h"

namespace sheen {

/// What a model is to be built from, and how; an empty text asks for nothing. Each is an option of `build`.
struct BuildRequest {
  std::string dataset;  ///< folder of a data set, a session or photographs alone, or a list of lights (.lp)
  std::string mesh, from_mesh, out, config, model, refine;
  std::optional<int> hold_out;
  bool no_refine = false;
  FavourArgument favour;
  LimitArguments limits;
  SizeArguments size;
  ObjectSizeArgument object_size;
};

/// Builds it and saves it. `done` is given the report, also of a model that is worth nothing and therefore not kept;
/// then Error is thrown. Throws ConfigError, FileError, and Error where a stop signal ends it (`stop_requested`).
void build(BuildRequest request, const std::function<void(const nlohmann::json&)>& done);

}  // namespace sheen
