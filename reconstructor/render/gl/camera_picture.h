// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/sketch.h"
#include "reconstructor/render/gl/textured_panel.h"

namespace sheen {

inline constexpr Rgba kUsedTagColor{60, 230, 90, 255}, kUnusedTagColor{255, 150, 40, 255};
inline constexpr Rgba kOutlineColor{255, 70, 200, 255};

/// The camera's image with what was found in it and what the pose says: the outlines of the tags (green: the pose rests
/// on it), the mesh's outline and the object's axes, all through the lens distortion.
class CameraPicture {
 public:
  CameraPicture();
  /// Image and outline, into a panel of the camera's shape; within the caller's scissor. The mesh may be null.
  void draw(const std::shared_ptr<const Capture>& capture, const Mesh* mesh, const Panel& panel, int target_height);
  /// Tags and axes over it.
  static Sketch annotations(const Capture& capture, const Mesh* mesh, const Panel& panel);

 private:
  void upload_image(const std::shared_ptr<const Capture>& capture);
  void draw_outline(const Capture& capture, const Mesh& mesh, const Panel& panel, int target_height);

  TexturedPanel image_;
  GlProgram mesh_program_, outline_program_;
  GlHandle vertex_array_;
  BufferTexture corners_;
  std::shared_ptr<const Capture> shown_;
};

}  // namespace sheen
