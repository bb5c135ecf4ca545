// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/capture/capture.h"
#include "reconstructor/capture/capture_end.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/monitor/monitor_state.h"
#include "reconstructor/render/gl/viewer_feed.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// Gathers what a running loop tells and puts it in the words of those who watch: the window and the monitor page.
/// Latest wins everywhere; the loop never waits.
class LiveDisplay {
 public:
  struct Names {
    struct Tracker {
      std::string endpoint, command;  ///< that starts one for us
    };
    std::string session_folder;
    std::vector<Tracker> trackers;
    std::string model;         ///< its kind; empty while it is not known
    std::string model_reason;  ///< why it was chosen; empty where the scene names it
    bool encrypted = false;
  };
  explicit LiveDisplay(Names names) : names_(std::move(names)) {}

  /// What the loop calls.
  LoopObserver observer();

  /// Shows from now on what is doubtful in the scene. From any thread.
  void warn(const std::string& warning);

  const ViewerFeed& feed() const { return feed_; }
  /// Hands the window what has come since.
  void publish_to_window(const LoopStatus& status, const EndProgress& end = {});
  /// Draws the small previews, so not for a thread that must be quick.
  MonitorState monitor_state(const LoopStatus& status, const EndProgress& end = {});

 private:
  struct Latest {
    std::shared_ptr<const ModelSnapshot> snapshot;
    std::shared_ptr<const RayPainter> painter;
    std::uint64_t number = 0;  ///< of the snapshot
    std::shared_ptr<const Capture> capture;
    std::optional<MonitorState::Clock::time_point> capture_at;  ///< of any camera
    std::vector<std::string> warnings;
  };
  bool takes_turn(const Capture& capture);
  Latest latest() const;
  void update_previews(const Latest& now);
  void update_next_view(const Latest& now);
  bool keeps_asking_for(const NextView& asked, const Latest& now, const Eigen::Vector3d& wanted);
  void count_surface(const Latest& now);
  std::string guidance_in_words(const Latest& now) const;

  Names names_;
  ViewerFeed feed_;
  mutable std::mutex mutex_;
  Latest latest_;
  MonitorState::Clock::time_point turn_began_;  ///< of the camera whose captures are shown
  std::uint64_t drawn_ = 0;                     ///< number of the snapshot
  std::shared_ptr<const Capture> drawn_capture_;
  std::shared_ptr<const std::string> preview_jpeg_, shape_jpeg_, camera_jpeg_;
  std::string preview_note_;
  std::uint64_t advised_ = 0, counted_ = 0;  ///< likewise
  MonitorState::Surface surface_;
  std::optional<NextView> next_view_;
  int otherwise_ = 0;  ///< snapshots in a row that want another view than `next_view_`
};

/// What the monitor page shows before the first image, while it is not known what will be modelled.
/// `latest`: capture; null: none has come. `doing`: what is done meanwhile.
MonitorState state_before_first(const LiveDisplay::Names& names, const std::vector<LinkState>& links,
                                const Capture* latest, std::string doing);

}  // namespace sheen
