// SPDX-License-Identifier: Apache-2.0
#include <malloc.h>

#include "common/base/command_line.h"
#include "common/base/log.h"
#include "reconstructor/commands/commands.h"

namespace {

/// What images take for a moment is given back at once: from the heap it would leave holes between patches. glibc, left
/// alone, learns to keep it there.
void give_large_blocks_back() {
  constexpr int kLarge = 2 << 20, kFreeAtTheTop = 8 << 20;  // bytes
  mallopt(M_MMAP_THRESHOLD, kLarge);
  mallopt(M_TRIM_THRESHOLD, kFreeAtTheTop);
}

}  // namespace

int main(int argc, char** argv) {
  give_large_blocks_back();
  sheen::CommandLine program("sheen-reconstructor",
                             "Makes a model of how an object looks from images with poses, live or from files.");
  program.require_subcommand();
  program.version(SHEEN_VERSION "\n" SHEEN_BUILT);
  sheen::add_serve_command(program);
  sheen::add_build_command(program);
  sheen::add_shape_command(program);
  sheen::add_refine_command(program);
  sheen::add_render_command(program);
  sheen::add_compress_command(program);
  sheen::add_evaluate_command(program);
  sheen::add_view_command(program);
  sheen::add_undo_command(program);
  sheen::add_monitor_command(program);
  sheen::add_doctor_command(program);
  sheen::add_tradeoff_command(program);
  sheen::add_figures_command(program);
  sheen::add_plan_lights_command(program);
  sheen::add_export_command(program);

  sheen::start_logging({});
  const int status = program.run(argc, argv);
  sheen::stop_logging();
  return status;
}
