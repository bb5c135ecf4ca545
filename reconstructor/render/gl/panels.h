// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "reconstructor/render/gl/gui.h"
#include "reconstructor/render/gl/panel.h"
#include "reconstructor/render/gl/panel_words.h"
#include "reconstructor/render/gl/sketch.h"
#include "reconstructor/render/gl/view_action.h"

namespace sheen {

/// What the panels are made of.
struct PanelContent {
  const ViewerState& state;
  const ViewControls& controls;
  const Told& told;
  const std::vector<Sketch>& sketches;
  std::vector<ViewAction> offered;  ///< those that have a button
};

/// What a hand did on the panels.
struct PanelEvents {
  std::vector<ViewAction> pressed;       ///< in this order
  std::optional<Eigen::Vector3d> light;  ///< moved there: object frame, unit
};

/// What lies over the picture: what is told at the top left, notes at the top right, the legend of the colours at the
/// bottom right, the light at the bottom left, buttons along the bottom, keys on demand. With an OpenGL context
/// current.
class Panels {
 public:
  /// Lays everything out for a picture of this size in pixels.
  PanelEvents lay_out(const PanelContent& content, int width, int height, float scale, const Pointer& pointer);
  /// What was laid out, into the framebuffer that is bound.
  void draw() { gui_.draw(); }
  /// Whether a panel lies there.
  bool cover(const Eigen::Vector2f& place) const;

 private:
  PanelEvents lay_out_once(const PanelContent& content, int width, int height, float scale, const Pointer& pointer);
  Gui gui_;
  std::vector<Panel> places_;
};

}  // namespace sheen
