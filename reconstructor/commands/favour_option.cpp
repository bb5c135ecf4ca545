// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/favour_option.h"

#include <algorithm>
#include <array>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "reconstructor/commands/limit_options.h"
#include "reconstructor/commands/size_options.h"

namespace sheen {
namespace {

/// What a word asks for; an empty text asks for nothing. No word limits the memory or sets a target: both are of a
/// scene.
struct Favour {
  const char *word, *budget, *tolerance, *loss;
};
constexpr std::array<Favour, 3> kFavours{{
    {"speed", "100ms", "0.02", "0.1dB"},
    {"accuracy", "", "0.005", "0.03dB"},
    {"size", "", "0.02", "0.3dB"},
}};

bool has_tolerance(ModelSettings& settings) {
  const std::vector<SettingKey> keys = settings.keys();
  return !settings.tolerance_is_between_lights() &&
         std::any_of(keys.begin(), keys.end(), [](const SettingKey& key) { return key.name == "tolerance"; });
}

}  // namespace

void FavourArgument::add_to(Command& command) {
  command
      .option("--favour", word,
              "what matters most; sets those of --budget, --tolerance and --loss that are not given (with --target, "
              "no tolerance)")
      .check(one_of({kFavours[0].word, kFavours[1].word, kFavours[2].word}));
}

void FavourArgument::fill(LimitArguments& limits, SizeArguments& size, ModelSettings& settings) const {
  const auto* const favour =
      std::find_if(kFavours.begin(), kFavours.end(), [this](const Favour& f) { return word == f.word; });
  if (word.empty()) return;
  if (favour == kFavours.end()) throw ConfigError("--favour: '" + word + "' is not speed, accuracy or size");
  if (limits.budget.empty()) limits.budget = favour->budget;
  if (limits.tolerance.empty() && limits.target.empty() && has_tolerance(settings))
    limits.tolerance = favour->tolerance;
  if (size.loss.empty() && size.bytes.empty()) size.loss = favour->loss;
}

}  // namespace sheen
