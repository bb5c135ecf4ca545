// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>

#include "reconstructor/models/appearance_model.h"

namespace sheen {

/// Writes the time since the last call under a stage's name.
class StageClock {
 public:
  explicit StageClock(IngestReport& report) : report_(report) {}
  void done(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    report_.stage_ms[stage] += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  IngestReport& report_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace sheen
