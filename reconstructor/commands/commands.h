// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

class Command;

// Each adds its subcommand to the program; one file per command. The work happens in the subcommand's callback,
// which throws sheen::Error; CommandLine::run maps ConfigError to exit status 2 and everything else to 1.
void add_serve_command(Command& program);
void add_build_command(Command& program);
void add_shape_command(Command& program);
void add_refine_command(Command& program);
void add_render_command(Command& program);
void add_compress_command(Command& program);
void add_evaluate_command(Command& program);
void add_view_command(Command& program);
void add_undo_command(Command& program);
void add_monitor_command(Command& program);
void add_doctor_command(Command& program);
void add_tradeoff_command(Command& program);
void add_figures_command(Command& program);
void add_plan_lights_command(Command& program);
void add_export_command(Command& program);

}  // namespace sheen
