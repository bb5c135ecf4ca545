// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sheen {

/// Where PATH has a program of that name; empty: nowhere.
std::filesystem::path program_in_path(const std::string& name);

/// Another program that works for this one. It is in a process group of its own, so that Ctrl-C reaches it by this
/// program alone, and it never outlives this program, however that ends.
class ChildProcess {
 public:
  /// Begins `program` (a path), whose output and errors are appended to `log`. `environment` is added to this
  /// program's. Throws FileError.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               const std::map<std::string, std::string>& environment, const std::filesystem::path& log);
  /// Ends it and what it has begun, where that still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Its exit status, or 128 and the number of the signal that ended it; nothing while it runs.
  std::optional<int> ended();

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

}  // namespace sheen
