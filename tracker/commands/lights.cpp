// SPDX-License-Identifier: Apache-2.0
#include "tracker/commands/lights.h"

#include "common/base/command_line.h"
#include "tracker/commands/commands.h"

namespace sheen {

void add_lights_command(Command& program) {
  Command command = program.subcommand("lights", "Finds where the lights of images were, and writes a list of them.");
  command.require_subcommand();
  add_lights_ball_command(command);
  add_lights_shadows_command(command);
}

}  // namespace sheen
