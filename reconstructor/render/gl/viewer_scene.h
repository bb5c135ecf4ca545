// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reconstructor/models/model_kind.h"
#include "reconstructor/render/gl/camera_picture.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/panel_words.h"
#include "reconstructor/render/gl/sketch.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/gl/viewer_state.h"

namespace sheen {

/// Draws a state as the controls ask, into any target; knows OpenGL but no window.
class ViewerScene {
 public:
  /// Of models of one kind. With a context current.
  ViewerScene(const ModelKind& kind, const DrawerOptions& options)
      : model_(kind.title()), surface_(kind.make_drawer(options)) {}

  /// Brings what is new to the GPU, a bounded part of it per call; true when all of it is there.
  bool update(const ViewerState& state) { return surface_->update(state.snapshot); }
  /// The samples of some rows of the picture, from `top` on; the target is cleared by the caller.
  void draw_rows(const ViewerState& state, const ViewControls& controls, const RenderTarget& target, int top, int rows);
  /// The same picture where pixels cost too much: what shows a surface is drawn as large as `coarse` and enlarged.
  void draw_coarse(const ViewerState& state, const ViewControls& controls, const RenderTarget& coarse,
                   const RenderTarget& target);

  /// What belongs over the picture, at a size in pixels: tags and pose in the camera's image; with `panels`, where the
  /// tracked camera is and where it should go.
  static std::vector<Sketch> sketches(const ViewerState& state, const ViewControls& controls, int width, int height);
  /// What the panels tell. `notes`: lines to show beside the state's own message.
  Told told(const ViewerState& state, const ViewControls& controls, std::vector<std::string> notes, int width,
            int height);

  /// Whether the picture is from the viewpoint's eye.
  bool follows_eye() const { return surface_->follows_eye(); }

 private:
  /// A part of the picture that shows the surface.
  struct SurfacePanel {
    Panel panel;
    Viewpoint viewpoint;
    SurfaceShading shading;
  };
  static std::vector<SurfacePanel> surface_panels(const ViewerState& state, const ViewControls& controls, int width,
                                                  int height);
  static Sketch guides(const ViewerState& state, const SurfacePanel& surface);

  struct ShownDemand {
    Demand of;
    std::shared_ptr<const ModelSnapshot> snapshot;
    DemandMap map;
  };
  const DemandMap& demand_map(const std::shared_ptr<const ModelSnapshot>& snapshot, Demand demand);

  const char* model_;  ///< what it is called
  std::unique_ptr<ModelDrawer> surface_;
  CameraPicture camera_;
  std::shared_ptr<const ModelSnapshot> counted_;  ///< of which `figures_` are
  SnapshotFigures figures_;
  std::optional<ShownDemand> demand_;  ///< the last one asked for
};

}  // namespace sheen
