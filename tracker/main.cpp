// SPDX-License-Identifier: Apache-2.0

#include "common/base/command_line.h"
#include "common/base/stop_signal.h"
#include "tracker/commands/commands.h"

int main(int argc, char** argv) {
  sheen::CommandLine program(
      "sheen-tracker",
      "Grabs images of a camera, finds its pose from a stage with tags, and streams images with poses.");
  program.require_subcommand();
  program.version(SHEEN_VERSION "\n" SHEEN_BUILT);
  sheen::add_run_command(program);
  sheen::add_simulate_command(program);
  sheen::add_calibrate_command(program);
  sheen::add_stage_command(program);
  sheen::add_preview_command(program);
  sheen::add_register_command(program);
  sheen::add_lights_command(program);
  sheen::add_cameras_command(program);
  sheen::add_doctor_command(program);
  sheen::add_keygen_command(program);

  sheen::install_stop_signals();
  return program.run(argc, argv);
}
