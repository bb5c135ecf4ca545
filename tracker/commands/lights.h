// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

class Command;

// The subcommands of `sheen-tracker lights`.
void add_lights_ball_command(Command& lights);
void add_lights_shadows_command(Command& lights);

}  // namespace sheen
