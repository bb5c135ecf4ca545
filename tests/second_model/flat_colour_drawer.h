// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/model_drawer.h"

namespace sheen::testing {

/// One colour per triangle; what is not known of it in red.
class FlatColourDrawer : public ModelDrawer {
 public:
  FlatColourDrawer();
  bool update(const std::shared_ptr<const ModelSnapshot>& snapshot) override;
  void draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) override;
  std::vector<std::string> notes() const override { return {"flat colours"}; }

 private:
  GlProgram program_;
  GlHandle vertex_array_;
  BufferTexture corners_;  ///< per corner of each triangle: x, y, z, 1
  BufferTexture colours_;  ///< per triangle: sRGB-encoded colour, whether it is unseen
  std::shared_ptr<const ModelSnapshot> shown_;
};

}  // namespace sheen::testing
