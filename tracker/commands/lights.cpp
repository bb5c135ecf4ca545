// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/lights.h"

#include <CLI/CLI.hpp>

#include "tracker/commands/commands.h"

namespace sheen {

void add_lights_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("lights", "Finds where the lights of images were, and writes a list of them.");
  command->require_subcommand(1);
  add_lights_ball_command(*command);
  add_lights_shadows_command(*command);
}

}  // namespace sheen
