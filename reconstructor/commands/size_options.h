// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "reconstructor/models/model_kind.h"
#include "reconstructor/models/model_settings.h"

namespace sheen {

class Command;

/// How small a model is to be saved: by default, so that its pictures lose 0.1 dB.
struct SizeArguments {
  std::string bytes, loss;

  /// `without_loss`: what --loss 0dB does.
  void add_to(Command& command, const std::string& without_loss = "; 0dB saves a folder of floats");
  /// Nothing where nothing may be lost (--loss 0dB) or the kind has no smaller form: the model is saved as it is.
  /// Throws ConfigError naming the option.
  std::optional<CompressionTarget> target(const ModelKind& kind) const;
  /// The same of a model that is to be made with these settings.
  std::optional<CompressionTarget> target(const ModelKind& kind, const ModelSettings& settings) const;
};

}  // namespace sheen
