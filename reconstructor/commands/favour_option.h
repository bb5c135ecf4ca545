// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

class Command;
struct LimitArguments;
struct ModelSettings;
struct SizeArguments;

/// One word in front of the options of limits and size: it sets those that are not given (docs/tradeoffs.md).
struct FavourArgument {
  std::string word;

  void add_to(Command& command);
  /// `settings`: of the model; what it does not know is left as it is. Throws ConfigError for
  /// another word.
  void fill(LimitArguments& limits, SizeArguments& size, ModelSettings& settings) const;
};

}  // namespace sheen
