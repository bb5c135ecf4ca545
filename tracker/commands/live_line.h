// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include "tracker/tracking_report.h"

namespace sheen {

/// What `run` tells the person who holds the camera while it runs: on a terminal one line that is written over, with
/// what is wrong in front; elsewhere a line when something begins or ceases to be wrong, at most every few seconds, and
/// one every ten seconds without news.
class LiveLine {
 public:
  explicit LiveLine(std::FILE* stream = stderr);
  ~LiveLine();
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;

  void show(const RigReport& rig);

 private:
  std::FILE* stream_;
  bool terminal_;
  std::string told_;
  std::chrono::steady_clock::time_point told_at_;
  std::uint64_t told_kept_ = 0;
};

/// "TOO FAST: MOTION BLUR  56 frames, 1 kept, 55 refused (54 motion_blur, 1 too_near)". Of several cameras with what
/// each kept: "LEFT: TOO FAST: MOTION BLUR  112 frames, 8 kept (left 1 of 56, right 7 of 56), 104 refused (...)".
std::string live_line(const RigReport& rig);

}  // namespace sheen
