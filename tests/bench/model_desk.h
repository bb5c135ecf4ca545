// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace sheen {

/// A desk that turns the model of a running capture all the time: it asks as `reconstructor/page/live.js` does, from
/// another eye for each of 30 pictures a second, and draws nothing.
class ModelDesk {
 public:
  /// `port`: of the monitor page on 127.0.0.1. `begins_rad`: where it looks from first, round the object.
  ModelDesk(int port, double begins_rad);

  /// No more questions. Milliseconds, each time that it had all of the model again: for how long the oldest change that
  /// it lacked had been there.
  std::vector<double> lags_ms();
  std::size_t bytes() const { return bytes_; }  ///< of all answers

 private:
  using Clock = std::chrono::steady_clock;
  using Rest = std::chrono::milliseconds;

  Rest ask_for_scene();
  Rest ask_for_changes();
  std::string get(const std::string& path);
  std::string eye() const;

  int port_;
  double begins_rad_;
  Clock::time_point begun_ = Clock::now();
  std::uint32_t scene_ = 0, changes_ = 0;
  bool entered_ = false;  ///< it has the scene
  bool more_ = false, caught_up_ = false;
  std::string from_, seen_;  ///< eyes: of its questions, and of which it was told last
  Clock::time_point behind_since_ = Clock::time_point::max();
  std::vector<double> lags_ms_;
  std::size_t bytes_ = 0;
  std::jthread thread_;
};

/// A desk that asks for the scene and takes nothing of the answer, as one whose lid is closed.
class StalledDesk {
 public:
  explicit StalledDesk(int port);
  ~StalledDesk();
  StalledDesk(const StalledDesk&) = delete;
  StalledDesk& operator=(const StalledDesk&) = delete;

 private:
  int socket_;
};

}  // namespace sheen
