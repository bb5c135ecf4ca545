// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/program_run.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

#include "common/base/errors.h"

namespace sheen {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ProgramRun run_program(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  const auto begin = std::chrono::steady_clock::now();
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  pid_t id = -1;
  const int failed = posix_spawn(&id, words[0], &files, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  int status = 0;
  rusage used{};
  pid_t ended = -1;
  while (failed == 0 && (ended = wait4(id, &status, 0, &used)) < 0 && errno == EINTR) {
  }
  if (ended != id || status != 0) throw Error(arguments[0] + " " + arguments[1] + " failed: see " + log.string());
  return {.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          .processor_s = seconds_of(used.ru_utime) + seconds_of(used.ru_stime),
          .peak_bytes = 1024.0 * static_cast<double>(used.ru_maxrss)};
}

}  // namespace sheen
