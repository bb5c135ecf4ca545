// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tracker/tracking_loop.h"

namespace sheen {

/// One camera of a rig that runs: where its frames come from, what they are tracked with, and where they go.
struct TrackedCamera {
  std::string name;  ///< empty where the rig has one camera
  std::unique_ptr<FrameSource> source;
  std::optional<Rig> rig;
  TrackingOptions options;
  CaptureSink* sink = nullptr;  ///< outlives the run
};

/// All cameras of a rig, each tracked by itself on threads of its own: what one of them refuses, or that it is
/// unplugged or fails, is nothing to the others.
class RigTracking {
 public:
  struct Hooks {
    std::function<bool()> stop;                      ///< from any camera's thread, at least ten times per second
    std::function<void(const Status&)> publish;      ///< of all cameras in one; one call at a time
    std::function<void(const RigReport&)> progress;  ///< so far; one call at a time
    std::function<void(const std::string&)> failed;  ///< a camera has, the others go on; says which one and why
  };

  /// Throws ConfigError as TrackingLoop does.
  explicit RigTracking(std::vector<TrackedCamera> cameras);
  ~RigTracking();

  /// Until every camera has ended, or `hooks.stop` says so.
  RigReport run(const Hooks& hooks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What the cameras of a rig say of themselves, as one: counters added up, and those of each as NAME/COUNTER. The state
/// is that of the camera that is worst off.
Status joined(const std::vector<std::pair<std::string, Status>>& cameras);

}  // namespace sheen
