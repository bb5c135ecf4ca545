// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/session/session.h"
#include "reconstructor/capture/first_capture.h"
#include "reconstructor/capture/live_display.h"
#include "reconstructor/capture/tracker_links.h"
#include "reconstructor/commands/serve_watch.h"
#include "reconstructor/monitor/monitor_server.h"
#include "reconstructor/render/gl/viewer_window.h"

namespace sheen {

/// A capture that `serve` receives before there is a model of it, and who watches: the log, the window and the monitor
/// page, of which there need be none (null).
struct CaptureToBegin {
  const std::string& folder;  ///< of the session
  Session& session;
  TrackerLinks& links;
  bool once;  ///< no other source follows one that ends
  const LiveDisplay::Names& names;
  LinkLog& log;
  MonitorServer* monitor;
  ViewerWindow*& window;
};

/// Nothing when a signal, or the window's closing, ended the wait. Throws Error where the only source ended without an
/// image.
std::optional<FirstCapture::Found> wait_for_first(CaptureToBegin capture);

/// The shape of the session, or the first that its images show; `rough`: `ShapeOptions::from`, or null. Null when a
/// signal, or the window's closing, ended the wait.
std::shared_ptr<const Mesh> wait_for_shape(CaptureToBegin capture, int hold_out_every,
                                           const std::shared_ptr<const Mesh>& rough);

}  // namespace sheen
