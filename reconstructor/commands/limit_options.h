// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "reconstructor/effort/limits.h"
#include "reconstructor/models/model_settings.h"

namespace sheen {

class Command;

/// What `build` and `serve` let a user ask of the model: time, accuracy, memory.
struct LimitArguments {
  std::string budget, target, memory, tolerance;

  void add_to(Command& command, const std::string& about_target);
  /// Lays the tolerance on the settings; the rest is the command's. Throws ConfigError naming the option.
  Limits apply(ModelSettings& settings) const;
  /// The tolerance in grey levels, of a model whose tolerance is between its lights; where one was given. Throws
  /// ConfigError.
  std::optional<double> between_lights(const ModelSettings& settings) const;
};

}  // namespace sheen
