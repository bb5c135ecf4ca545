// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace sheen::testing {

struct ProcessOptions {
  std::map<std::string, std::string> environment;  ///< added to that of the test; an empty value removes the variable
  std::optional<std::uint64_t> file_bytes;         ///< no file may grow beyond: writing more fails as on a full disk
};

/// How a process ended: by itself or by a signal.
struct ProcessEnd {
  int status = -1;  ///< exit status, -1 after a signal
  int signal = 0;
};

/// A program of its own, whose standard output and error go to one file. It does not outlive this object or the test.
class Process {
 public:
  /// `arguments[0]` is the executable, looked for in PATH.
  explicit Process(const std::vector<std::string>& arguments, const ProcessOptions& options = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// How it ended; nothing if it still runs after `timeout`.
  std::optional<ProcessEnd> wait(std::chrono::milliseconds timeout);
  bool running() { return !wait(std::chrono::milliseconds(0)); }
  void signal(int number);
  /// SIGKILL, and gone when it returns.
  void kill();
  pid_t id() const { return pid_; }
  /// What it has printed so far.
  std::string output() const;
  /// Waits until it has printed `text`; false when it has ended or `timeout` has passed without.
  bool prints(const std::string& text, std::chrono::milliseconds timeout);

 private:
  pid_t pid_ = -1;
  std::optional<ProcessEnd> end_;
  std::filesystem::path output_;
};

/// A TCP port of 127.0.0.1 that nobody listened on a moment ago.
int free_port();

}  // namespace sheen::testing
