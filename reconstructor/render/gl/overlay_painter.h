// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "reconstructor/render/gl/gl_objects.h"
#include "reconstructor/render/gl/model_drawer.h"

namespace sheen {

using Rgba = std::array<std::uint8_t, 4>;  ///< sRGB-encoded, alpha not premultiplied

/// Flat drawing over a picture: rectangles, lines and text, in pixels from the top left corner. Edges are smooth by
/// themselves: one sample a pixel is enough. Everything is collected and drawn, in order, by `flush`.
class OverlayPainter {
 public:
  OverlayPainter();

  /// Starts a picture of this size. `text_unit`: a sixth of a capital's height, in pixels.
  void begin(int width, int height, float text_unit);
  void fill(float x, float y, float width, float height, Rgba color);
  void triangle(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c, Rgba color);
  void line(const Eigen::Vector2f& from, const Eigen::Vector2f& to, float width, Rgba color);
  /// Top left corner at (x, y). What is not printable ASCII is shown as '?'. `scale`: of the letters.
  void text(float x, float y, std::string_view text, Rgba color, float scale = 1);
  /// Draws what was collected, clipped to the panel.
  void flush(const Panel& panel);

  int width() const { return width_; }
  int height() const { return height_; }
  float advance() const { return static_cast<float>(cell_width_); }       ///< of one character
  float line_height() const { return static_cast<float>(cell_height_); }  ///< of one line of text

 private:
  struct Vertex {
    float x, y;
    float u, v;                     ///< place in the atlas, or in the box: pixels from its middle
    float half_width, half_height;  ///< of the box; < 0: a glyph
    Rgba color;
  };
  /// A rectangle, turned so that its width lies along a unit vector.
  void box(const Eigen::Vector2f& middle, const Eigen::Vector2f& along, float half_width, float half_height,
           Rgba color);
  void quad(const std::array<Vertex, 4>& corners);

  GlProgram program_;
  GlHandle vertex_array_, vertex_buffer_, atlas_;
  std::vector<Vertex> vertices_;
  int width_ = 0, height_ = 0;
  float text_unit_ = 0;
  int cell_width_ = 0, cell_height_ = 0;
};

}  // namespace sheen
