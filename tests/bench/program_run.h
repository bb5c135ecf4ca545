// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheen {

/// What running a program took.
struct ProgramRun {
  double wall_s = 0;
  double processor_s = 0;  ///< of all its threads, in user and system
  double peak_bytes = 0;   ///< of resident memory; not less than what the caller had when it started it
};

/// Runs a program to its end. `arguments[0]` is its file; what it prints goes to `log`. Throws Error naming the log
/// where it fails.
ProgramRun run_program(const std::vector<std::string>& arguments, const std::filesystem::path& log);

}  // namespace sheen
