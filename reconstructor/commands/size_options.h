// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "reconstructor/models/model_snapshot.h"

namespace CLI {
class App;
}

namespace sheen {

/// How small `build` and `compress` are to make a model.
struct SizeArguments {
  std::string bytes, loss;

  void add_to(CLI::App& command);
  /// Empty where neither is asked for. Throws ConfigError naming the option.
  std::optional<CompressionTarget> target() const;
};

}  // namespace sheen
