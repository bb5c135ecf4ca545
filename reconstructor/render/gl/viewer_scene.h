// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "reconstructor/models/model_kind.h"
#include "reconstructor/render/gl/camera_picture.h"
#include "reconstructor/render/gl/hud.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/overlay_painter.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/gl/viewer_state.h"

namespace sheen {

/// Draws a state as the controls ask, into any target; knows OpenGL but no window.
class ViewerScene {
 public:
  /// Of models of one kind. With a context current.
  ViewerScene(const ModelKind& kind, const DrawerOptions& options) : surface_(kind.make_drawer(options)) {}

  /// Brings what is new to the GPU, a bounded part of it per call; true when all of it is there.
  bool update(const ViewerState& state) { return surface_->update(state.snapshot); }
  /// `news`: lines to show beside the state's own message.
  void draw(const ViewerState& state, const ViewControls& controls, const std::vector<std::string>& news,
            const RenderTarget& target);

 private:
  void draw_surface(const ViewerState& state, const ViewControls& controls, const Panel& area, SurfaceShading shading);
  void draw_camera(const ViewerState& state, const Panel& area);
  void draw_guides(const ViewerState& state, const Viewpoint& viewpoint, const Panel& panel);
  void draw_hud(const ViewerState& state, const ViewControls& controls, std::vector<std::string> notes);

  std::unique_ptr<ModelDrawer> surface_;
  CameraPicture camera_;
  OverlayPainter overlay_;
  std::shared_ptr<const ModelSnapshot> counted_;  ///< of which `ranks_` are
  SnapshotFigures ranks_;
};

}  // namespace sheen
