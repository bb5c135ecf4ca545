// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/camera_picture.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/capture/linear_capture.h"
#include "common/image/color.h"

namespace sheen {
namespace {

// Vertices come projected, as the lens distorts them. A triangle with a corner that has no image is dropped.
constexpr const char* kCorners = R"glsl(#version 330 core
uniform samplerBuffer corners;
bool visible(int first) {
  return texelFetch(corners, first).w > 0.0 && texelFetch(corners, first + 1).w > 0.0 &&
         texelFetch(corners, first + 2).w > 0.0;
}
)glsl";

constexpr const char* kMeshVertexShader = R"glsl(
void main() {
  int first = gl_VertexID - gl_VertexID % 3;
  gl_Position = visible(first) ? vec4(texelFetch(corners, gl_VertexID).xyz, 1) : vec4(2, 2, 2, 1);
}
)glsl";

// Each side of each triangle as a bar that reaches so far round it, behind all of the mesh.
constexpr const char* kOutlineVertexShader = R"glsl(
uniform vec2 half_size;  // of the panel, pixels
uniform float reach;     // pixels
uniform float depth;
void main() {
  int first = 3 * (gl_VertexID / 18), side = gl_VertexID % 18 / 6, corner = gl_VertexID % 6;
  vec2 from = half_size * texelFetch(corners, first + side).xy;
  vec2 to = half_size * texelFetch(corners, first + (side + 1) % 3).xy;
  vec2 along = to - from;
  along = length(along) > 0.0 ? normalize(along) : vec2(1, 0);
  vec2 across = vec2(-along.y, along.x);
  bool at_end = corner == 1 || corner == 2 || corner == 4, left = corner == 2 || corner == 4 || corner == 5;
  vec2 place = (at_end ? to + reach * along : from - reach * along) + (left ? reach : -reach) * across;
  gl_Position = visible(first) ? vec4(place / half_size, depth, 1) : vec4(2, 2, 2, 1);
}
)glsl";

constexpr const char* kFlatFragmentShader = R"glsl(#version 330 core
uniform vec4 flat_color;
out vec4 color;
void main() { color = flat_color; }
)glsl";

constexpr float kMeshIsNearer = 0.999998f, kBehindTheOutline = 0.999999f;  // depths: all of a mesh is less

float outline_reach(int height) {
  return std::max(1.5f, static_cast<float>(height) / 360);
}

/// Image pixels -> pixels of the target.
Eigen::Vector2f on_panel(const Panel& panel, const Camera& camera, const Eigen::Vector2d& pixel) {
  return {static_cast<float>(panel.x + (pixel.x() + 0.5) * panel.width / camera.width),
          static_cast<float>(panel.y + (pixel.y() + 0.5) * panel.height / camera.height)};
}

void add_tags(const Capture& capture, const Panel& panel, Sketch& sketch) {
  for (const TagObservation& tag : capture.tags) {
    const Rgba color = tag.used ? kUsedTagColor : kUnusedTagColor;
    Eigen::Vector2f middle = Eigen::Vector2f::Zero();
    std::array<Eigen::Vector2f, 4> corners;
    for (int i = 0; i < 4; ++i) {
      corners[i] = on_panel(panel, capture.camera, tag.corners[i]);
      middle += 0.25f * corners[i];
    }
    for (int i = 0; i < 4; ++i) sketch.lines.push_back({corners[i], corners[(i + 1) % 4], 2, color});
    sketch.labels.push_back({middle, std::to_string(tag.id), color});
  }
}

/// Red x, green y, blue z from the origin of the object frame.
void add_axes(const Capture& capture, double length, const Panel& panel, Sketch& sketch) {
  constexpr int kPieces = 12;  // axes bend with the lens
  constexpr Rgba kColors[3] = {{255, 70, 60, 255}, {70, 220, 70, 255}, {80, 140, 255, 255}};
  for (int axis = 0; axis < 3; ++axis) {
    std::optional<Eigen::Vector2f> before;
    for (int i = 0; i <= kPieces; ++i) {
      const Eigen::Vector3d point = Eigen::Vector3d::Unit(axis) * (length * i / kPieces);
      const auto pixel = capture.camera.project(capture.pose.camera_from_object * point);
      const std::optional<Eigen::Vector2f> at =
          pixel ? std::optional(on_panel(panel, capture.camera, *pixel)) : std::nullopt;
      if (before && at) sketch.lines.push_back({*before, *at, 3, kColors[axis]});
      before = at;
    }
    if (before) sketch.labels.push_back({*before, std::string(1, "xyz"[axis]), kColors[axis]});
  }
}

}  // namespace

CameraPicture::CameraPicture()
    : mesh_program_("mesh in the camera image", std::string(kCorners) + kMeshVertexShader, kFlatFragmentShader),
      outline_program_("outline of the mesh", std::string(kCorners) + kOutlineVertexShader, kFlatFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      corners_(GL_RGBA32F, 16) {}

void CameraPicture::upload_image(const std::shared_ptr<const Capture>& capture) {
  if (capture == shown_) return;
  image_.upload(to_srgb8(linear_radiance(*capture)), TexturedPanel::Scaling::kMipmaps);
  shown_ = capture;
}

void CameraPicture::draw_outline(const Capture& capture, const Mesh& mesh, const Panel& panel, int target_height) {
  const Camera& camera = capture.camera;
  const BoundingSphere object = bounding_sphere(mesh);
  const double depth = (capture.pose.camera_from_object * object.centre).z();
  const double far = depth + 1.01 * object.radius, near = std::max(depth - 1.01 * object.radius, 1e-3 * far);
  std::vector<Eigen::Vector4f> projected(mesh.vertices.size(), Eigen::Vector4f::Zero());
  for (std::size_t v = 0; v < projected.size(); ++v) {
    const Eigen::Vector3d p = capture.pose.camera_from_object * mesh.vertices[v].cast<double>();
    const auto pixel = camera.project(p);
    if (!pixel || !(p.z() > 0)) continue;
    const double inverse_depth = (far + near - 2 * far * near / p.z()) / (far - near);  // linear over the picture
    projected[v] = {static_cast<float>((2 * pixel->x() + 1) / camera.width - 1),
                    static_cast<float>(1 - (2 * pixel->y() + 1) / camera.height), static_cast<float>(inverse_depth), 1};
  }
  std::vector<Eigen::Vector4f> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) corners.push_back(projected[v]);
  corners_.assign(corners.size(), corners.data());

  glViewport(panel.x, target_height - panel.y - panel.height, panel.width, panel.height);
  glBindVertexArray(vertex_array_.id());
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  corners_.bind(0);
  mesh_program_.use();
  glUniform1i(mesh_program_.uniform("corners"), 0);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);  // the image stays where the mesh is, and hides what is behind
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners.size()));
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);

  const float reach = outline_reach(panel.height);
  outline_program_.use();
  glUniform1i(outline_program_.uniform("corners"), 0);
  glUniform2f(outline_program_.uniform("half_size"), 0.5f * static_cast<float>(panel.width),
              0.5f * static_cast<float>(panel.height));
  const auto draw_round = [&](float pixels, float layer, const Eigen::Vector4f& color) {
    glUniform1f(outline_program_.uniform("reach"), pixels);
    glUniform1f(outline_program_.uniform("depth"), layer);
    glUniform4fv(outline_program_.uniform("flat_color"), 1, color.data());
    glDrawArrays(GL_TRIANGLES, 0, 6 * static_cast<GLsizei>(corners.size()));
  };
  const auto [r, g, b, opaque] = kOutlineColor;
  draw_round(reach, kMeshIsNearer, Eigen::Vector4f(r, g, b, opaque) / 255);
  glEnable(GL_BLEND);  // a dark rim round it, for bright images; the depth keeps bars from darkening each other
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE);
  draw_round(reach + 1, kBehindTheOutline, {0, 0, 0, 0.5f});
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
}

void CameraPicture::draw(const std::shared_ptr<const Capture>& capture, const Mesh* mesh, const Panel& panel,
                         int target_height) {
  upload_image(capture);
  image_.draw(panel, target_height);
  if (capture->pose.usable() && mesh) draw_outline(*capture, *mesh, panel, target_height);
  check_gl("drawing the camera picture");
}

Sketch CameraPicture::annotations(const Capture& capture, const Mesh* mesh, const Panel& panel) {
  Sketch sketch{.clip = panel};
  add_tags(capture, panel, sketch);
  if (capture.pose.usable()) add_axes(capture, mesh ? 0.6 * bounding_sphere(*mesh).radius : 0.05, panel, sketch);
  return sketch;
}

}  // namespace sheen
