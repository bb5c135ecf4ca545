// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/log.h"
#include "reconstructor/commands/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Makes a model of how an object looks from images with poses, live or from files.",
               "sheen-reconstructor");
  app.require_subcommand(1);
  app.set_version_flag("--version", SHEEN_VERSION);
  sheen::add_serve_command(app);
  sheen::add_build_command(app);
  sheen::add_refine_command(app);
  sheen::add_render_command(app);
  sheen::add_compress_command(app);
  sheen::add_evaluate_command(app);
  sheen::add_view_command(app);
  sheen::add_undo_command(app);
  sheen::add_monitor_command(app);
  sheen::add_doctor_command(app);
  sheen::add_tradeoff_command(app);
  sheen::add_figures_command(app);
  sheen::add_plan_lights_command(app);
  sheen::add_export_command(app);

  sheen::start_logging({});
  const int status = sheen::run_program(app, argc, argv);
  sheen::stop_logging();
  return status;
}
