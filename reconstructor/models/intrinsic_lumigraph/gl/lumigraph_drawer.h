// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "reconstructor/models/intrinsic_lumigraph/lumigraph_painter.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/model_drawer.h"

namespace sheen {

/// Draws an intrinsic lumigraph: its picture is made by the processor and shown as it is, its surface with its depth.
class LumigraphDrawer : public ModelDrawer {
 public:
  LumigraphDrawer();
  bool update(const std::shared_ptr<const ModelSnapshot>& snapshot) override;
  void draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) override;
  std::vector<std::string> notes() const override;

 private:
  /// Paints and uploads, where viewpoint or light have changed.
  void refresh(const Viewpoint& viewpoint, const LightState& light);

  GlProgram program_;
  GlHandle vertex_array_, texture_;
  std::optional<LumigraphPainter> painter_;
  std::optional<Viewpoint> shown_from_;  ///< what the texture shows; empty: nothing
};

}  // namespace sheen
