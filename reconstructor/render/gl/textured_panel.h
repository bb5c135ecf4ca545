// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/image/image.h"
#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/panel.h"

namespace sheen {

/// The largest panel of a picture's shape in the middle of an area.
Panel fit(const Panel& area, int width, int height);

/// A picture that the processor made, or a camera, drawn over a panel. With a context current; throws DeviceError.
class TexturedPanel {
 public:
  enum class Scaling {
    kNone,     ///< a pixel for a pixel
    kSmooth,   ///< enlarged
    kMipmaps,  ///< made smaller, too
  };
  TexturedPanel();
  /// 8-bit sRGB.
  void upload(const ImageU8& picture, Scaling scaling);

  struct Look {
    bool black_is_empty = false;                ///< black pixels leave what is there
    std::optional<Eigen::Vector3f> color = {};  ///< in place of the picture's colours: sRGB-encoded, 0..1
  };
  /// All of `panel`, which counts from the top of a target of that height.
  void draw(const Panel& panel, int target_height, const Look& look) const;
  void draw(const Panel& panel, int target_height) const { draw(panel, target_height, {}); }

 private:
  GlProgram program_;
  GlHandle vertex_array_, texture_;
};

}  // namespace sheen
