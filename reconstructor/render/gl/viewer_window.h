// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>

#include "common/image/image.h"
#include "reconstructor/models/model_kind.h"
#include "reconstructor/render/gl/frame_pacer.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/gl/viewer_feed.h"
#include "reconstructor/render/gl/viewer_state.h"

namespace sheen {

struct ViewerOptions {
  int width = 1280, height = 800;  ///< pixels
  bool visible = true;             ///< false: for pictures only; still needs a display
  int samples = 4;                 ///< per pixel, against jagged outlines; 1 = none
  std::filesystem::path screenshot_folder = ".";
  DrawerOptions drawer;
};

/// What the window asks of a capture. Each returns a line for the person; without one there is no such button.
struct CaptureRequests {
  std::function<std::string()> take_back = {};  ///< the last image
  std::function<std::string()> hold_out = {};   ///< the next image
};

/// The window (GLFW, OpenGL 3.3, Dear ImGui). One per process; made, used and destroyed on the main thread. Its keys
/// and buttons: `view_actions`.
class ViewerWindow {
 public:
  /// For models of one kind. Throws DeviceError without a display or without OpenGL 3.3: the message says what to do.
  ViewerWindow(const ModelKind& kind, const ViewerOptions& options);
  ~ViewerWindow();

  ViewControls& controls();

  /// Shows what is published until the person quits or a stop is asked for; the window stays until this object goes,
  /// and may be run again. Draws only when something has changed. Throws DeviceError when OpenGL fails or the display
  /// goes away.
  void run(const ViewerFeed& feed, const std::stop_token& stop, CaptureRequests requests = {});

  /// One picture of `options.width` x `options.height` with all of the state on the GPU, and with the panels where the
  /// controls have them.
  ImageU8 draw_once(const ViewerState& state);
  /// The picture that the window shows first while a person moves it, as coarse as this machine asks for.
  ImageU8 draw_soon(const ViewerState& state);
  const FramePacer& pacer() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
