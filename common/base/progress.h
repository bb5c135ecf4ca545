// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>

namespace sheen {

/// Called from time to time by long work with the number of steps that are done. What it throws ends the work and
/// reaches the caller of the work. Empty: not called.
using StepsDone = std::function<void(std::size_t done, std::size_t steps)>;

/// Characters in a line of the terminal; 80 where it does not say.
int terminal_width(std::FILE* stream);

/// A progress bar on a terminal: fraction done, rate, time left. Where `stream` is no terminal (a pipe, a file) it
/// writes a line every ten seconds. The bar goes at the end. Whoever prints meanwhile does so within a `ProgressPause`.
class Progress {
 public:
  /// `total` 0: unknown; counts and rate only.
  Progress(std::string label, std::uint64_t total, std::FILE* stream = stderr);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Cheap enough for every image: the terminal is written to at most ten times per second.
  void update(std::uint64_t done);

 private:
  std::string label_;
  std::uint64_t total_;
  std::FILE* stream_;
  bool terminal_;
  std::chrono::steady_clock::time_point started_, shown_;
};

/// A bar for a `StepsDone`, from its first call until its last copy is gone.
StepsDone progress_bar(std::string label);

/// While one lives no bar stands on the terminal, so that a line can be printed there; the next `update` shows the bar
/// again. From any thread.
class ProgressPause {
 public:
  ProgressPause();

 private:
  std::lock_guard<std::mutex> lock_;
};

/// What `Progress` shows, in at most `width` columns (40 or more); without a bar where there is no room or no total:
///   building [#########.........] 45/90  50 %  5.2/s  9 s left
std::string progress_line(const std::string& label, std::uint64_t done, std::uint64_t total, double elapsed_s,
                          int width);

}  // namespace sheen
