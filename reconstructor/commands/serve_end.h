// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/capture/capture_end.h"
#include "reconstructor/capture/capture_loop.h"
#include "reconstructor/render/gl/viewer_window.h"

namespace sheen {

/// What a person is told whose capture ends without its model: nothing is lost by that.
struct EarlyEnd {
  std::string session;        ///< where the captures are kept
  std::string build_command;  ///< makes their model
};

/// The model and the report of what was captured; a bar per stage on the terminal. A signal, or the window's closing,
/// ends it within a second: then throws Error, or leaves the program where what is being done does not stop in time.
CaptureEnd::Result end_capture(CaptureLoop& loop, CaptureEnd& end, ViewerWindow*& window, const ViewerFeed& feed,
                               const EarlyEnd& early);

}  // namespace sheen
