// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "reconstructor/render/demand_map.h"
#include "reconstructor/render/gl/overlay_painter.h"
#include "reconstructor/render/gl/view_controls.h"
#include "reconstructor/render/gl/viewer_state.h"
#include "reconstructor/render/guidance.h"

namespace sheen {

/// The text over the picture: figures at the top left, where to go next at the bottom, the legend of the colours at the
/// bottom right, keys on demand. Collected into `overlay`, not flushed.
struct Hud {
  const ViewerState& state;
  const ViewControls& controls;
  const char* model;                       ///< what it is called: "surface light field"
  const SnapshotFigures* ranks = nullptr;  ///< null without a model
  const DemandMap* demand = nullptr;       ///< null where it is not what is shown
  const Guidance* guidance = nullptr;      ///< null without a next view
  std::vector<std::string> notes;          ///< warnings and news, a line each
  void draw(OverlayPainter& overlay) const;

 private:
  float bottom_margin(const OverlayPainter& overlay) const;
  void draw_figures(OverlayPainter& overlay) const;
  void draw_guidance(OverlayPainter& overlay) const;
  void draw_work(OverlayPainter& overlay) const;
  void draw_trouble(OverlayPainter& overlay) const;
  void draw_legend(OverlayPainter& overlay) const;
  void draw_notes(OverlayPainter& overlay) const;
  void draw_help(OverlayPainter& overlay) const;
};

}  // namespace sheen
