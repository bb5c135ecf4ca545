// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "tracker/tracking_report.h"

namespace sheen {

/// What `run` tells the person who holds the camera while it runs: on a terminal one line that is written over, with
/// what is wrong in front; elsewhere a line when something begins or ceases to be wrong, at most every few seconds.
class LiveLine {
 public:
  explicit LiveLine(std::FILE* stream = stderr);
  ~LiveLine();
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;

  void show(const TrackingReport& report);

 private:
  std::FILE* stream_;
  bool terminal_;
  std::string told_;
  std::optional<std::chrono::steady_clock::time_point> told_at_;
};

/// "TOO FAST: MOTION BLUR  56 frames, 1 kept, 55 refused (54 motion_blur, 1 too_near)".
std::string live_line(const TrackingReport& report);

}  // namespace sheen
