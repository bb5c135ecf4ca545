// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <map>
#include <string>

namespace sheen {

/// Adds the time since the last call to a stage, in milliseconds.
class StageClock {
 public:
  explicit StageClock(std::map<std::string, double>& stage_ms) : stage_ms_(stage_ms) {}
  void done(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    stage_ms_[stage] += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  std::map<std::string, double>& stage_ms_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace sheen
