// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/overlay_painter.h"

#include <epoxy/gl.h>

#include <cmath>
#include <cstddef>

#include "reconstructor/render/gl/stroke_font.h"

namespace sheen {
namespace {

constexpr const char* kVertexShader = R"glsl(#version 330 core
layout(location = 0) in vec2 position;
layout(location = 1) in vec2 place;
layout(location = 2) in vec2 half_size;
layout(location = 3) in vec4 tint;
uniform vec2 size;
out vec2 shape_place;
flat out vec2 shape_half;
out vec4 shape_color;

void main() {
  shape_place = place;
  shape_half = half_size;
  shape_color = tint;
  gl_Position = vec4(2.0 * position.x / size.x - 1.0, 1.0 - 2.0 * position.y / size.y, 0, 1);
}
)glsl";

constexpr const char* kFragmentShader = R"glsl(#version 330 core
uniform sampler2D atlas;
in vec2 shape_place;
flat in vec2 shape_half;
in vec4 shape_color;
out vec4 color;

// Of a glyph as in the atlas; of a box the part of the pixel that lies in it, as if its sides were the pixel's.
float coverage() {
  if (shape_half.x < 0.0) return texelFetch(atlas, ivec2(shape_place), 0).r;
  vec2 low = max(shape_place - 0.5, -shape_half), high = min(shape_place + 0.5, shape_half);
  vec2 inside = max(high - low, vec2(0));
  return inside.x * inside.y;
}

void main() { color = vec4(shape_color.rgb, shape_color.a * coverage()); }
)glsl";

}  // namespace

OverlayPainter::OverlayPainter()
    : program_("overlay", kVertexShader, kFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      vertex_buffer_(make_gl_buffer()),
      atlas_(make_gl_texture()) {
  glBindVertexArray(vertex_array_.id());
  glBindBuffer(GL_ARRAY_BUFFER, vertex_buffer_.id());
  const auto attribute = [](GLuint location, GLint size, GLenum type, GLboolean normalized, std::size_t offset) {
    glEnableVertexAttribArray(location);
    glVertexAttribPointer(location, size, type, normalized, sizeof(Vertex), reinterpret_cast<const void*>(offset));
  };
  attribute(0, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, x));
  attribute(1, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, u));
  attribute(2, 2, GL_FLOAT, GL_FALSE, offsetof(Vertex, half_width));
  attribute(3, 4, GL_UNSIGNED_BYTE, GL_TRUE, offsetof(Vertex, color));
  check_gl("setting up the overlay");
}

void OverlayPainter::begin(int width, int height, float text_unit) {
  width_ = width;
  height_ = height;
  vertices_.clear();
  if (text_unit == text_unit_) return;
  const GlyphAtlas glyphs = draw_glyphs(text_unit);
  text_unit_ = text_unit;
  cell_width_ = glyphs.cell_width;
  cell_height_ = glyphs.cell_height;
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, atlas_.id());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, glyphs.coverage.width(), glyphs.coverage.height(), 0, GL_RED, GL_UNSIGNED_BYTE,
               glyphs.coverage.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

void OverlayPainter::quad(const std::array<Vertex, 4>& corners) {
  for (const int i : {0, 1, 2, 0, 2, 3}) vertices_.push_back(corners[i]);
}

void OverlayPainter::box(const Eigen::Vector2f& middle, const Eigen::Vector2f& along, float half_width,
                         float half_height, Rgba color) {
  const Eigen::Vector2f across(-along.y(), along.x());
  const float u = half_width + 1, v = half_height + 1;  // all pixels that the box touches have their centres in there
  const auto corner = [&](float a, float b) {
    const Eigen::Vector2f p = middle + a * along + b * across;
    return Vertex{p.x(), p.y(), a, b, half_width, half_height, color};
  };
  quad({corner(-u, -v), corner(u, -v), corner(u, v), corner(-u, v)});
}

void OverlayPainter::fill(float x, float y, float width, float height, Rgba color) {
  box({x + width / 2, y + height / 2}, {1, 0}, width / 2, height / 2, color);
}

void OverlayPainter::triangle(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c,
                              Rgba color) {
  constexpr float kEverywhere = 1e6f;
  for (const Eigen::Vector2f& p : {a, b, c}) vertices_.push_back({p.x(), p.y(), 0, 0, kEverywhere, kEverywhere, color});
  line(a, b, 1, color);
  line(b, c, 1, color);
  line(c, a, 1, color);
}

void OverlayPainter::line(const Eigen::Vector2f& from, const Eigen::Vector2f& to, float width, Rgba color) {
  const Eigen::Vector2f along = to - from;
  const float length = along.norm();
  if (!(length > 0)) return;
  box((from + to) / 2, along / length, length / 2, width / 2, color);
}

void OverlayPainter::text(float x, float y, std::string_view text, Rgba color, float scale) {
  x = std::round(x);  // glyphs are drawn pixel for pixel
  y = std::round(y);
  const float w = advance(), h = line_height();
  for (const char character : text) {
    const bool printable = character >= GlyphAtlas::kFirst && character <= GlyphAtlas::kLast;
    const int cell = (printable ? character : '?') - GlyphAtlas::kFirst;
    const float u = w * static_cast<float>(cell % GlyphAtlas::kColumns);
    const float v = h * static_cast<float>(cell / GlyphAtlas::kColumns);
    if (character != ' ')
      quad({{{x, y, u, v, -1, -1, color},
             {x + scale * w, y, u + w, v, -1, -1, color},
             {x + scale * w, y + scale * h, u + w, v + h, -1, -1, color},
             {x, y + scale * h, u, v + h, -1, -1, color}}});
    x += scale * w;
  }
}

void OverlayPainter::flush(const Panel& panel) {
  if (vertices_.empty()) return;
  program_.use();
  glUniform2f(program_.uniform("size"), static_cast<float>(width_), static_cast<float>(height_));
  glUniform1i(program_.uniform("atlas"), 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, atlas_.id());
  glBindVertexArray(vertex_array_.id());
  glBindBuffer(GL_ARRAY_BUFFER, vertex_buffer_.id());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices_.size() * sizeof(Vertex)), vertices_.data(),
               GL_STREAM_DRAW);
  glViewport(0, 0, width_, height_);
  const ScissorScope scissor(panel, height_);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices_.size()));
  glDisable(GL_BLEND);
  vertices_.clear();
}

}  // namespace sheen
