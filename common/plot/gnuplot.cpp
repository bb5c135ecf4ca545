// SPDX-License-Identifier: Apache-2.0
#include "common/plot/gnuplot.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/base/errors.h"

namespace sheen {

std::string gnuplot_string(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "''" : std::string(1, c);
  return out + "'";
}

PlotFiles run_gnuplot(const std::filesystem::path& script) {
  const std::string name = script.filename().string(), folder = script.parent_path().string();
  const char* const arguments[] = {"gnuplot", name.c_str(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t child = 0;
  const int failed =
      posix_spawnp(&child, arguments[0], &actions, nullptr, const_cast<char* const*>(arguments), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) return PlotFiles::kTableOnly;
  int status = 0;
  if (waitpid(child, &status, 0) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw FileError(script.string(), "gnuplot could not draw it; its messages are above");
  return PlotFiles::kDrawn;
}

}  // namespace sheen
