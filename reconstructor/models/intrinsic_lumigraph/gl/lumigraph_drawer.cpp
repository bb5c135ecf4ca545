// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/gl/lumigraph_drawer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>

#include "common/image/color.h"

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
uniform float need;
in vec2 place;
out vec4 pixel;
void main() {
  vec3 rgb = texture(picture, place).rgb;
  if (rgb == vec3(0.0)) discard;
  pixel = need >= 0.0 ? vec4(need, 0.0, 0.0, 1.0) : vec4(rgb, 1.0);
}
)glsl";

bool same_view(const Viewpoint& a, const Viewpoint& b) {
  return a.camera == b.camera && a.camera_from_object.translation == b.camera_from_object.translation &&
         a.camera_from_object.rotation.coeffs() == b.camera_from_object.rotation.coeffs() &&
         a.light_turn == b.light_turn;
}

/// Turned round the object's z axis, and up as far as the zenith or the horizon.
Eigen::Vector3d turned_light(const Eigen::Vector3d& place, const Eigen::Vector2d& turn) {
  const double azimuth = std::atan2(place.y(), place.x()) + turn.x(),
               elevation = std::clamp(std::asin(place.normalized().z()) + turn.y(), 0.02, M_PI / 2);
  return place.norm() * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
}

}  // namespace

LumigraphDrawer::LumigraphDrawer()
    : program_("intrinsic lumigraph", kVertexShader, kFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      texture_(make_gl_texture()) {}

bool LumigraphDrawer::update(const std::shared_ptr<const ModelSnapshot>& snapshot) {
  const auto model = std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(snapshot);
  if (painter_ && painter_->model() == model) return true;
  painter_.reset();
  if (model) painter_.emplace(model);
  shown_from_.reset();
  return true;
}

std::vector<std::string> LumigraphDrawer::notes() const {
  return {"Ctrl and the mouse turn the light"};
}

void LumigraphDrawer::refresh(const Viewpoint& viewpoint, const LightState& light) {
  if (shown_from_ && same_view(*shown_from_, viewpoint)) return;
  const ImageU8 picture = to_srgb8(painter_->paint({viewpoint.camera, viewpoint.camera_from_object}, light));
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.width(), picture.height(), 0, GL_RGB, GL_UNSIGNED_BYTE,
               picture.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  shown_from_ = viewpoint;
}

void LumigraphDrawer::draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) {
  if (!painter_ || painter_->model()->empty()) return;
  const IntrinsicLumigraphSnapshot& model = *painter_->model();
  LightState light{.kind = model.light_kind(), .position = model.light_place({})};
  light.position = turned_light(light.position, viewpoint.light_turn);
  refresh(viewpoint, light);
  const bool needs = shading == SurfaceShading::kHeuristic || shading == SurfaceShading::kReasons;
  program_.use();
  glUniform1f(program_.uniform("need"), needs ? std::min(1.0f, static_cast<float>(model.data()->error / 0.1)) : -1);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, texture_.id());
  glUniform1i(program_.uniform("picture"), 0);
  const Panel& panel = area.panel;
  glViewport(panel.x, area.target_height - panel.y - panel.height, panel.width, panel.height);
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(vertex_array_.id());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  check_gl("drawing an intrinsic lumigraph");
}

}  // namespace sheen
