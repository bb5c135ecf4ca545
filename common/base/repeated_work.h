// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace sheen {

/// Does something again and again, on a thread of its own, until this object goes. A round that fails is logged
/// (SparingLog), and the next one comes as ever: for what shows a capture and must not end it.
class RepeatedWork {
 public:
  /// `component` speaks in the log. `pause`: after each round.
  RepeatedWork(const std::string& component, std::chrono::milliseconds pause, std::function<void()> round);

 private:
  std::jthread thread_;
};

}  // namespace sheen
