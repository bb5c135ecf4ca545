// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/limit_options.h"

#include <charconv>

#include "common/base/command_line.h"
#include "common/base/errors.h"
#include "reconstructor/effort/effort_control.h"

namespace sheen {

void LimitArguments::add_to(Command& command, const std::string& about_target) {
  command.option("--budget", budget, "time per image, such as 33ms; the model is made coarser until it is kept");
  command.option("--target", target, about_target);
  command.option("--memory", memory, "memory that the model may use, such as 1GB");
  command.option(
      "--tolerance", tolerance,
      "relative error that a patch may keep, such as 0.01 or 40dB; of a model between lights, grey levels such as "
      "16: its lights are judged by it");
}

Limits LimitArguments::apply(ModelSettings& settings) const {
  const Limits limits = parse_limits(budget, target, memory);
  if (!tolerance.empty() && !settings.tolerance_is_between_lights())
    set(settings, "tolerance", parse_tolerance(tolerance));
  return limits;
}

std::optional<double> LimitArguments::between_lights(const ModelSettings& settings) const {
  if (tolerance.empty() || !settings.tolerance_is_between_lights()) return std::nullopt;
  double grey_levels = 0;
  const auto [end, error] = std::from_chars(tolerance.data(), tolerance.data() + tolerance.size(), grey_levels);
  if (error != std::errc() || end != tolerance.data() + tolerance.size() || !(grey_levels >= 0.1 && grey_levels <= 255))
    throw ConfigError("--tolerance: '" + tolerance + "' is not a number of grey levels from 0.1 to 255, such as 16");
  return grey_levels;
}

}  // namespace sheen
