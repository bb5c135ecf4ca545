// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/textured_panel.h"

namespace sheen {

/// Draws an intrinsic lumigraph: its picture is made by the processor and shown as it is.
class LumigraphDrawer : public ModelDrawer {
 public:
  bool update(const std::shared_ptr<const ModelSnapshot>& snapshot) override;
  void draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) override;

 private:
  /// Paints and uploads, where viewpoint or light have changed.
  void refresh(const Viewpoint& viewpoint, const LightState& light);

  TexturedPanel picture_;
  std::optional<LumigraphPainter> painter_;
  std::optional<Viewpoint> shown_from_;  ///< what the picture shows; empty: nothing
};

}  // namespace sheen
