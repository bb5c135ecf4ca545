// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/limit_options.h"

#include <CLI/CLI.hpp>

#include "common/base/errors.h"
#include "reconstructor/effort/effort_control.h"

namespace sheen {

void LimitArguments::add_to(CLI::App& command, const std::string& about_target) {
  command.add_option("--budget", budget, "time per image, such as 33ms; the model is made coarser until it is kept");
  command.add_option("--target", target, about_target);
  command.add_option("--memory", memory, "memory that the model may use, such as 1GB");
  command.add_option("--tolerance", tolerance, "relative error that a patch may keep, such as 0.01 or 40dB");
}

Limits LimitArguments::apply(ModelSettings& settings) const {
  const Limits limits = parse_limits(budget, target, memory);
  if (!tolerance.empty()) set(settings, "tolerance", parse_tolerance(tolerance));
  return limits;
}

}  // namespace sheen
