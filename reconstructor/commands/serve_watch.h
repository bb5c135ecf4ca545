// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/capture/live_display.h"
#include "reconstructor/models/model_kind.h"
#include "reconstructor/render/gl/viewer_window.h"

namespace sheen {

// Who watches a capture that `serve` receives: the window, the log.

/// Without a display there is no window; without asking, there is no capture that nobody sees either: throws
/// DeviceError that names --headless.
void open_window(std::optional<ViewerWindow>& window, const ModelKind& kind, const ViewerOptions& options);
/// Where the window can open only later: that it will. Throws the same.
void require_display();

/// Until `over` or, where there is a window, the person closes it. A window that is lost is set to null.
void wait_until(const std::function<bool()>& over, ViewerWindow*& window, const ViewerFeed& feed,
                const CaptureRequests& requests = {});

/// Tells the log when each tracker comes and goes, why it refuses, and when its source has ended.
class LinkLog {
 public:
  void look(const std::vector<LinkState>& links);

 private:
  std::vector<LinkState> links_;
};

/// Adds to an observer: the first captures tell whether the mesh, which must outlive it, is where and as large as the
/// object. What is doubtful goes to the log and to `display`.
void watch_mesh(const Mesh& mesh, LiveDisplay& display, LoopObserver& observer);
/// Adds to an observer: it tells once, in the same places, when something moves that the model takes to stand still.
void watch_motion(const ModelKind& kind, LiveDisplay& display, LoopObserver& observer);

/// Tells a finding in the same places.
std::function<void(const std::string&)> tells_findings(LiveDisplay& display);

}  // namespace sheen
