// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "common/base/command_line.h"
#include "common/base/stop_signal.h"
#include "tracker/commands/commands.h"

int main(int argc, char** argv) {
  CLI::App app("Grabs images of a camera, finds its pose from a stage with tags, and streams images with poses.",
               "sheen-tracker");
  app.require_subcommand(1);
  app.set_version_flag("--version", SHEEN_VERSION);
  sheen::add_run_command(app);
  sheen::add_simulate_command(app);
  sheen::add_calibrate_command(app);
  sheen::add_stage_command(app);
  sheen::add_preview_command(app);
  sheen::add_register_command(app);
  sheen::add_lights_command(app);
  sheen::add_cameras_command(app);
  sheen::add_doctor_command(app);
  sheen::add_keygen_command(app);

  sheen::install_stop_signals();
  return sheen::run_program(app, argc, argv);
}
