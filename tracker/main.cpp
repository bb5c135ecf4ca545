// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "common/errors.h"
#include "common/stop_signal.h"
#include "tracker/commands/commands.h"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

int report(const std::exception& error, int status) {
  std::cerr << "sheen-tracker: " << error.what() << '\n';
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Grabs a camera, solves its pose against a stage of tags and streams posed images.", "sheen-tracker");
  app.require_subcommand(1);
  sheen::add_run_command(app);
  sheen::add_simulate_command(app);
  sheen::add_stage_command(app);
  sheen::add_cameras_command(app);
  sheen::add_doctor_command(app);
  sheen::add_keygen_command(app);

  sheen::install_stop_signals();
  try {
    app.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  } catch (const sheen::ConfigError& error) {
    return report(error, kWrongUsage);
  } catch (const std::exception& error) {
    return report(error, kFailed);
  }
}
