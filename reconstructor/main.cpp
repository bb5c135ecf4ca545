// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <cstdio>

#include "common/errors.h"
#include "common/log.h"
#include "reconstructor/commands/commands.h"

int main(int argc, char** argv) {
  CLI::App app("sheen-reconstructor: turns posed images into a surface light field, live or from files.");
  app.require_subcommand(1);
  app.set_version_flag("--version", SHEEN_VERSION);
  sheen::add_serve_command(app);
  sheen::add_build_command(app);
  sheen::add_render_command(app);
  sheen::add_evaluate_command(app);
  sheen::add_view_command(app);
  sheen::add_undo_command(app);
  sheen::add_monitor_command(app);
  sheen::add_doctor_command(app);
  sheen::add_tradeoff_command(app);
  sheen::add_figures_command(app);

  sheen::start_logging({});
  const auto status = [](int s) {
    sheen::stop_logging();
    return s;
  };

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return status(app.exit(error) == 0 ? 0 : 2);
  } catch (const sheen::ConfigError& error) {
    std::fprintf(stderr, "sheen-reconstructor: %s\n", error.what());
    return status(2);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sheen-reconstructor: %s\n", error.what());
    return status(1);
  }
  return status(0);
}
