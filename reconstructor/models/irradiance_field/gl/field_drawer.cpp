// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/gl/field_drawer.h"

#include <epoxy/gl.h>

#include <algorithm>

namespace sheen {
namespace {

constexpr const char* kVertexShader = R"glsl(#version 330 core
uniform vec2 part;
out vec2 place;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  place = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(part * (2.0 * corner - 1.0), 0.0, 1.0);
}
)glsl";

constexpr const char* kFragmentShader = R"glsl(#version 330 core
uniform sampler2D picture;
uniform float need;
in vec2 place;
out vec4 pixel;
void main() { pixel = need >= 0.0 ? vec4(need, 0.0, 0.0, 1.0) : vec4(texture(picture, place).rgb, 1.0); }
)glsl";

}  // namespace

FieldDrawer::FieldDrawer()
    : program_("irradiance field", kVertexShader, kFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      texture_(make_gl_texture()) {}

bool FieldDrawer::update(const std::shared_ptr<const ModelSnapshot>& snapshot) {
  if (snapshot == shown_) return true;
  shown_ = std::dynamic_pointer_cast<const IrradianceFieldSnapshot>(snapshot);
  lit_from_.setZero();
  return true;
}

void FieldDrawer::relight(const Eigen::Vector3d& from) {
  if (from == lit_from_) return;
  LightState light{.kind = shown_->scene().kind, .position = from};
  // A lamp as far away as those of the images were.
  if (light.kind == LightKind::kPoint) light.position *= shown_->scene().lights.colwise().norm().mean();
  const ImageU8 picture = shown_->screen_picture(light);
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.width(), picture.height(), 0, GL_RGB, GL_UNSIGNED_BYTE,
               picture.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  lit_from_ = from;
}

void FieldDrawer::draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) {
  if (!shown_ || shown_->empty()) return;
  const Eigen::Vector3d from = (viewpoint.eye() - bounding_sphere(shown_->mesh()).centre).normalized();
  relight(from);
  const Panel& panel = area.panel;
  const bool needs = shading == SurfaceShading::kHeuristic || shading == SurfaceShading::kReasons;
  const double shape = static_cast<double>(shown_->field().size.width) / shown_->field().size.height,
               panel_shape = static_cast<double>(panel.width) / panel.height;
  program_.use();
  glUniform2f(program_.uniform("part"), static_cast<float>(std::min(1.0, shape / panel_shape)),
              static_cast<float>(std::min(1.0, panel_shape / shape)));
  glUniform1f(program_.uniform("need"), needs ? std::min(1.0f, static_cast<float>(shown_->scene().error / 0.1)) : -1);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glUniform1i(program_.uniform("picture"), 0);
  glViewport(panel.x, area.target_height - panel.y - panel.height, panel.width, panel.height);
  glBindVertexArray(vertex_array_.id());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  check_gl("drawing an irradiance field");
}

}  // namespace sheen
