// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "common/camera/camera.h"
#include "common/link/status.h"
#include "common/stage/stage_layout.h"
#include "tracker/capture_sink.h"
#include "tracker/lights/frame_lights.h"
#include "tracker/pose/keyframe_gate.h"
#include "tracker/pose/stage_finder.h"
#include "tracker/sources/frame_source.h"
#include "tracker/tracking_report.h"

namespace sheen {

/// What a source without given poses is tracked with.
struct Rig {
  Camera camera;
  StageLayout stage;
  bool still = false;                      ///< the camera does not move: all frames have the pose of the first keyframe
  std::shared_ptr<FrameLights> lights;     ///< null: the light does not change
  std::optional<Photometry> photometry{};  ///< empty: not measured
};

struct TrackingOptions {
  StageFinderOptions finder;
  GateOptions gate;
  std::uint64_t max_frames = 0;  ///< grabbed; 0 is all that come
  std::size_t queue = 16;        ///< frames that wait between grabbing and tracking: a quarter of a second at 60/s
  std::string source_session;    ///< of the captures; empty leaves it to the sink
  std::string camera_name;       ///< in front of the captures' names, where a rig has several cameras; else empty
};

/// grab -> detect -> refine -> solve -> gate -> send. Grabbing has its own thread and a bounded queue: a camera that is
/// faster than the tracker loses frames, which are counted; a file waits.
class TrackingLoop {
 public:
  struct Hooks {
    std::function<bool()> stop;                  ///< asked at least ten times per second
    std::function<void(const Status&)> publish;  ///< about five times per second, and when the source's state changes
    std::function<void(const TrackingReport&)> progress;  ///< so far; as often; may be empty
  };

  /// `rig` may be empty for a source whose images come with poses. Throws ConfigError otherwise.
  TrackingLoop(FrameSource& source, CaptureSink& sink, std::optional<Rig> rig, const TrackingOptions& options);
  ~TrackingLoop();

  /// Until the source ends or fails, `max_frames` have been grabbed or `hooks.stop` says so. What a source throws, or a
  /// frame that nothing can be done with, ends the run and stands in the report: what was kept is still to be
  /// delivered.
  TrackingReport run(const Hooks& hooks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
