// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/textured_panel.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr const char* kVertexShader = R"glsl(#version 330 core
out vec2 place;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  place = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
)glsl";

constexpr const char* kFragmentShader = R"glsl(#version 330 core
uniform sampler2D picture;
uniform bool black_is_empty;
uniform vec3 flat_color;  // negative: the picture's own
in vec2 place;
out vec4 pixel;
void main() {
  vec3 rgb = texture(picture, place).rgb;
  if (black_is_empty && rgb == vec3(0.0)) discard;
  pixel = vec4(flat_color.r >= 0.0 ? flat_color : rgb, 1.0);
}
)glsl";

}  // namespace

Panel fit(const Panel& area, int width, int height) {
  const double scale = std::min(double(area.width) / width, double(area.height) / height);
  const int w = std::max(1, static_cast<int>(std::lround(width * scale)));
  const int h = std::max(1, static_cast<int>(std::lround(height * scale)));
  return {area.x + (area.width - w) / 2, area.y + (area.height - h) / 2, w, h};
}

TexturedPanel::TexturedPanel()
    : program_("picture", kVertexShader, kFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      texture_(make_gl_texture()) {}

void TexturedPanel::upload(const ImageU8& picture, Scaling scaling) {
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.width(), picture.height(), 0, GL_RGB, GL_UNSIGNED_BYTE,
               picture.data());
  if (scaling == Scaling::kMipmaps) glGenerateMipmap(GL_TEXTURE_2D);
  const GLint near = scaling == Scaling::kNone ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, scaling == Scaling::kMipmaps ? GL_LINEAR_MIPMAP_LINEAR : near);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, near);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  check_gl("uploading a picture");
}

void TexturedPanel::draw(const Panel& panel, int target_height, const Look& look) const {
  program_.use();
  glUniform1i(program_.uniform("picture"), 0);
  glUniform1i(program_.uniform("black_is_empty"), look.black_is_empty);
  glUniform3fv(program_.uniform("flat_color"), 1, look.color.value_or(Eigen::Vector3f(-1, -1, -1)).data());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glViewport(panel.x, target_height - panel.y - panel.height, panel.width, panel.height);
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(vertex_array_.id());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  check_gl("drawing a picture");
}

}  // namespace sheen
