// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace sheen {

// The subcommands of `sheen-tracker lights`.
void add_lights_ball_command(CLI::App& lights);
void add_lights_shadows_command(CLI::App& lights);

}  // namespace sheen
