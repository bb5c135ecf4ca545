// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/effort/tradeoff_wish.h"
#include "reconstructor/models/surface_light_field/surface_light_field.h"

namespace CLI {
class App;
}

namespace sheen {

/// What `build` and `serve` let a user ask of the model: time, accuracy, memory.
struct WishArguments {
  std::string budget, target, memory, tolerance;

  void add_to(CLI::App& command, const std::string& about_target);
  /// Lays the tolerance on the options; the rest is the command's. Throws ConfigError naming the option.
  TradeoffWish apply(SurfaceLightFieldOptions& options) const;
};

}  // namespace sheen
