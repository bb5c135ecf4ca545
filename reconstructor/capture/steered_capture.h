// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/monitor/steering.h"

namespace sheen {

/// The session's metadata: what was asked from other desks, a line each: time (UTC), address, what was done.
inline constexpr const char* kSteeringKey = "steering";

/// What other desks ask of a capture is taken by `ask`, from any thread, and carried out one after the other by whoever
/// calls `carry_out`. Each is logged, and written into the session.
class SteeredCapture {
 public:
  /// `Steer`. Not taken while sixteen others wait.
  std::string ask(const SteerRequest& request);
  void carry_out(CaptureLoop& loop);
  /// Somebody has asked for the end.
  bool finishes() const { return finishes_; }
  /// What was done since the start, as it is written into the session.
  std::vector<std::string> lines() const;

 private:
  std::string done(const SteerRequest& request, CaptureLoop& loop);

  mutable std::mutex mutex_;
  std::deque<SteerRequest> waiting_;
  std::vector<std::string> lines_;
  std::atomic<bool> finishes_{false};
};

/// What the person who took the last image back is told.
std::string take_back_last(CaptureLoop& loop);
/// What the person is told whose next image judges the model.
std::string hold_out_next(CaptureLoop& loop);

}  // namespace sheen
