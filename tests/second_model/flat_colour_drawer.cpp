// SPDX-License-Identifier: Apache-2.0
#include "tests/second_model/flat_colour_drawer.h"

#include <epoxy/gl.h>

#include "common/image/color.h"
#include "tests/second_model/flat_colour.h"

namespace sheen::testing {
namespace {

constexpr const char* kVertexShader = R"glsl(#version 330 core
uniform samplerBuffer corners, colours;
uniform mat4 clip_from_object;
flat out vec4 colour;
void main() {
  colour = texelFetch(colours, gl_VertexID / 3);
  gl_Position = clip_from_object * texelFetch(corners, gl_VertexID);
}
)glsl";

constexpr const char* kFragmentShader = R"glsl(#version 330 core
uniform bool needs;
flat in vec4 colour;
out vec4 pixel;
void main() { pixel = needs ? vec4(colour.a, 0, 0, 1) : vec4(colour.rgb, 1); }
)glsl";

}  // namespace

FlatColourDrawer::FlatColourDrawer()
    : program_("flat colour", kVertexShader, kFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      corners_(GL_RGBA32F, 16),
      colours_(GL_RGBA32F, 16) {}

bool FlatColourDrawer::update(const std::shared_ptr<const ModelSnapshot>& snapshot) {
  if (!snapshot || snapshot == shown_) return true;
  const auto& flat = dynamic_cast<const FlatColourSnapshot&>(*snapshot);
  std::vector<Eigen::Vector4f> corners, colours;
  for (std::size_t t = 0; t < flat.mesh().triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) corners.push_back(flat.mesh().corner(t, c).homogeneous());
    const Eigen::Vector3f& rgb = flat.colours()[t];
    colours.emplace_back(srgb_encode(rgb.x()), srgb_encode(rgb.y()), srgb_encode(rgb.z()), flat.seen(t) ? 0.0f : 1.0f);
  }
  corners_.assign(corners.size(), corners.data());
  colours_.assign(colours.size(), colours.data());
  shown_ = snapshot;
  return true;
}

void FlatColourDrawer::draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) {
  if (!shown_) return;
  program_.use();
  const Eigen::Matrix4f clip = clip_from_object(viewpoint, bounding_sphere(shown_->mesh()));
  glUniformMatrix4fv(program_.uniform("clip_from_object"), 1, GL_FALSE, clip.data());
  glUniform1i(program_.uniform("needs"), shading == SurfaceShading::kHeuristic || shading == SurfaceShading::kReasons);
  glUniform1i(program_.uniform("corners"), 0);
  glUniform1i(program_.uniform("colours"), 1);
  corners_.bind(0);
  colours_.bind(1);
  const Panel& panel = area.panel;
  glViewport(panel.x, area.target_height - panel.y - panel.height, panel.width, panel.height);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  glBindVertexArray(vertex_array_.id());
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(3 * shown_->mesh().triangles.size()));
  glDisable(GL_DEPTH_TEST);
  check_gl("drawing flat colours");
}

}  // namespace sheen::testing
