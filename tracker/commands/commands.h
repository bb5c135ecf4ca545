// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

class Command;

// Each adds its subcommand to the program; one file per command. The work happens in the subcommand's callback,
// which throws sheen::Error; CommandLine::run maps ConfigError to exit status 2 and everything else to 1.
void add_run_command(Command& program);
void add_simulate_command(Command& program);
void add_calibrate_command(Command& program);
void add_stage_command(Command& program);
void add_preview_command(Command& program);
void add_register_command(Command& program);
void add_lights_command(Command& program);
void add_cameras_command(Command& program);
void add_doctor_command(Command& program);
void add_keygen_command(Command& program);

}  // namespace sheen
