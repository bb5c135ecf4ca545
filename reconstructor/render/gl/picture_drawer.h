// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "reconstructor/render/gl/frame_pacer.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/viewer_scene.h"

namespace sheen {

/// Draws pictures of a state as fast as a person moves them and as fine as the window shows them: coarse at once, and
/// fine in pieces between which the window looks after its mouse. Knows OpenGL but no window.
class PictureDrawer {
 public:
  /// Of models of one kind; `samples` per pixel of fine pictures. With a context current.
  PictureDrawer(const ModelKind& kind, const DrawerOptions& options, int samples)
      : scene_(kind, options), samples_(samples) {}

  /// Brings what is new to the GPU, a bounded part of it per call; true when all of it is there.
  bool update(const ViewerState& state) { return scene_.update(state); }
  /// Of the window, in pixels. Throws DeviceError.
  void resize(int width, int height);

  /// A picture that is soon there. True: it is as fine as can be.
  bool draw_soon(const ViewerState& state, const ViewControls& controls);
  /// The next piece of the fine picture; true when that was the last one and the picture is there. Until then the one
  /// before stays. State and controls must be those of the pieces before: `restart` where they are not.
  bool draw_piece(const ViewerState& state, const ViewControls& controls);
  void restart() { rows_drawn_ = 0; }
  /// The fine picture, whole.
  void draw_fine(const ViewerState& state, const ViewControls& controls);

  ViewerScene& scene() { return scene_; }
  const FramePacer& pacer() const { return pacer_; }
  /// After `resize`.
  const RenderTarget& target() const { return *target_; }

 private:
  int rows_per_piece() const;

  ViewerScene scene_;
  int samples_;
  FramePacer pacer_;
  std::optional<RenderTarget> target_, coarse_;
  int rows_drawn_ = 0;    ///< of the fine picture
  double pieces_ms_ = 0;  ///< that they took
};

}  // namespace sheen
