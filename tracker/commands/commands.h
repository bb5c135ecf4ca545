// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace sheen {

// Each adds its subcommand to the application; one file per command. The work happens in the subcommand's callback,
// which throws sheen::Error; main maps ConfigError to exit status 2 and everything else to 1.
void add_run_command(CLI::App& app);
void add_simulate_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);
void add_stage_command(CLI::App& app);
void add_preview_command(CLI::App& app);
void add_register_command(CLI::App& app);
void add_lights_command(CLI::App& app);
void add_cameras_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_keygen_command(CLI::App& app);

}  // namespace sheen
