// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace CLI {
class App;
}

namespace sheen {

// Each adds its subcommand to the application; one file per command. The work happens in the subcommand's callback,
// which throws sheen::Error; main maps ConfigError to exit status 2 and everything else to 1.
void add_serve_command(CLI::App& app);
void add_build_command(CLI::App& app);
void add_refine_command(CLI::App& app);
void add_render_command(CLI::App& app);
void add_compress_command(CLI::App& app);
void add_evaluate_command(CLI::App& app);
void add_view_command(CLI::App& app);
void add_undo_command(CLI::App& app);
void add_monitor_command(CLI::App& app);
void add_doctor_command(CLI::App& app);
void add_tradeoff_command(CLI::App& app);
void add_figures_command(CLI::App& app);
void add_plan_lights_command(CLI::App& app);
void add_export_command(CLI::App& app);

}  // namespace sheen
