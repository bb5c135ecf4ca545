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
constexpr const char* kMeshVertexShader = R"glsl(#version 330 core
uniform samplerBuffer corners;
out vec3 beta;
void main() {
  int first = gl_VertexID - gl_VertexID % 3;
  bool visible = texelFetch(corners, first).w > 0.0 && texelFetch(corners, first + 1).w > 0.0 &&
                 texelFetch(corners, first + 2).w > 0.0;
  int corner = gl_VertexID % 3;
  beta = vec3(corner == 0, corner == 1, corner == 2);
  gl_Position = visible ? vec4(texelFetch(corners, gl_VertexID).xyz, 1) : vec4(2, 2, 2, 1);
}
)glsl";

constexpr const char* kMeshFragmentShader = R"glsl(#version 330 core
in vec3 beta;
out vec4 color;
void main() {
  vec3 pixels = beta / max(fwidth(beta), vec3(1e-6));  // distance to each edge
  float line = 1.0 - smoothstep(0.4, 1.1, min(pixels.x, min(pixels.y, pixels.z)));
  color = vec4(0.25, 0.85, 1.0, 0.38 * line);
}
)glsl";

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
    : mesh_program_("mesh over the camera image", kMeshVertexShader, kMeshFragmentShader),
      vertex_array_(make_gl_vertex_array()),
      corners_(GL_RGBA32F, 16) {}

void CameraPicture::upload_image(const std::shared_ptr<const Capture>& capture) {
  if (capture == shown_) return;
  image_.upload(to_srgb8(linear_radiance(*capture)), TexturedPanel::Scaling::kMipmaps);
  shown_ = capture;
}

void CameraPicture::draw_mesh(const Capture& capture, const Mesh& mesh, const Panel& panel, int target_height) {
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

  mesh_program_.use();
  glUniform1i(mesh_program_.uniform("corners"), 0);
  corners_.bind(0);
  glViewport(panel.x, target_height - panel.y - panel.height, panel.width, panel.height);
  glBindVertexArray(vertex_array_.id());
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);  // first the depth, so that hidden edges stay hidden
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners.size()));
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthFunc(GL_LEQUAL);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners.size()));
  glDisable(GL_BLEND);
  glDepthFunc(GL_LESS);
  glDisable(GL_DEPTH_TEST);
}

void CameraPicture::draw(const std::shared_ptr<const Capture>& capture, const Mesh* mesh, const Panel& panel,
                         int target_height) {
  upload_image(capture);
  image_.draw(panel, target_height);
  if (capture->pose.usable() && mesh) draw_mesh(*capture, *mesh, panel, target_height);
  check_gl("drawing the camera picture");
}

Sketch CameraPicture::annotations(const Capture& capture, const Mesh* mesh, const Panel& panel) {
  Sketch sketch{.clip = panel};
  add_tags(capture, panel, sketch);
  if (capture.pose.usable()) add_axes(capture, mesh ? 0.6 * bounding_sphere(*mesh).radius : 0.05, panel, sketch);
  return sketch;
}

}  // namespace sheen
