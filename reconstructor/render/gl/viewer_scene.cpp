// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/viewer_scene.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr Rgba kTracked{255, 215, 90, 255}, kNext{90, 220, 120, 255}, kDivider{90, 95, 105, 255};

bool posed(const ViewerState& state) {
  return state.capture && state.capture->pose.usable();
}

/// The tracked camera as a pinhole that fills the panel: its lens distortion is left out.
Viewpoint tracked_viewpoint(const Capture& capture, const Panel& panel) {
  Camera camera = capture.camera.scaled(panel.width, panel.height);
  camera.lens = LensModel::kOpenCv;
  camera.distortion = {};
  return {camera, capture.pose.camera_from_object};
}

/// Capitals of 9 pixels in a window of 800 and below, larger in larger ones.
float text_unit(int height) {
  return std::clamp(std::round(static_cast<float>(height) / 250) / 2, 1.5f, 5.0f);
}

}  // namespace

void ViewerScene::draw(const ViewerState& state, const ViewControls& controls, const std::vector<std::string>& news,
                       const RenderTarget& target) {
  target.clear({0.11f, 0.12f, 0.135f});
  overlay_.begin(target.width(), target.height(), text_unit(target.height()));

  const Panel all{0, 0, target.width(), target.height()};
  const SurfaceShading need = controls.reasons ? SurfaceShading::kReasons : SurfaceShading::kHeuristic;
  const bool untouched = state.snapshot && state.snapshot->empty();
  const SurfaceShading seen = controls.states ? SurfaceShading::kStates
                              : untouched     ? SurfaceShading::kPlain
                                              : SurfaceShading::kAppearance;
  std::vector<std::string> notes = news;
  switch (controls.mode) {
    case ViewMode::kLightField:
      draw_surface(state, controls, all, seen);
      break;
    case ViewMode::kHeuristic:
      draw_surface(state, controls, all, need);
      break;
    case ViewMode::kSplit: {
      const int half = std::max(1, all.width / 2);
      draw_surface(state, controls, {0, 0, half, all.height}, seen);
      draw_surface(state, controls, {all.width - half, 0, half, all.height}, need);
      overlay_.fill(static_cast<float>(half) - 1, 0, 2, static_cast<float>(all.height), kDivider);
      break;
    }
    case ViewMode::kCamera:
      if (state.capture)
        draw_camera(state, all);
      else
        notes.push_back("no camera image");
      break;
  }
  if (controls.mode != ViewMode::kCamera) {
    if (!state.snapshot) notes.push_back("no model");
    if (controls.follow && !posed(state)) notes.push_back("no tracked camera to follow");
  }
  if (controls.figures) draw_hud(state, controls, std::move(notes));
  overlay_.flush(all);
  check_gl(std::string("drawing the view '") + to_string(controls.mode) + "'");
}

void ViewerScene::draw_surface(const ViewerState& state, const ViewControls& controls, const Panel& area,
                               SurfaceShading shading) {
  if (!state.snapshot) return;
  const bool follow = controls.follow && posed(state);
  const Panel panel = follow ? fit(area, state.capture->camera.width, state.capture->camera.height) : area;
  Viewpoint viewpoint =
      follow ? tracked_viewpoint(*state.capture, panel) : controls.orbit.viewpoint(panel.width, panel.height);
  viewpoint.light_turn = controls.light_turn;
  surface_->draw(viewpoint, panel, overlay_.height(), shading);
  if (controls.figures && !follow) draw_guides(state, viewpoint, panel);
}

void ViewerScene::draw_camera(const ViewerState& state, const Panel& area) {
  const Panel panel = fit(area, state.capture->camera.width, state.capture->camera.height);
  camera_.draw(state.capture, state.snapshot ? &state.snapshot->mesh() : nullptr, panel, overlay_);
}

/// Where the tracked camera is and where it should go, in the free camera's picture.
void ViewerScene::draw_guides(const ViewerState& state, const Viewpoint& viewpoint, const Panel& panel) {
  const Eigen::Vector2f origin(static_cast<float>(panel.x) + 0.5f, static_cast<float>(panel.y) + 0.5f);
  const auto pixel = [&](const Eigen::Vector3d& point) -> std::optional<Eigen::Vector2f> {
    const auto p = viewpoint.camera.project(viewpoint.camera_from_object * point);
    if (!p) return std::nullopt;
    return p->cast<float>() + origin;
  };
  const auto line = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, Rgba color) {
    const auto from = pixel(a), to = pixel(b);
    if (from && to) overlay_.line(*from, *to, 1.5f, color);
  };
  const double size = 0.35 * bounding_sphere(state.snapshot->mesh()).radius;
  if (posed(state)) {
    const Camera& camera = state.capture->camera;
    const Rigid3 object_from_camera = state.capture->pose.camera_from_object.inverse();
    const double x = 0.5 * camera.width / camera.fx * size, y = 0.5 * camera.height / camera.fy * size;
    const Eigen::Vector3d corners[4] = {{-x, -y, size}, {x, -y, size}, {x, y, size}, {-x, y, size}};
    for (int i = 0; i < 4; ++i) {
      line(object_from_camera.translation, object_from_camera * corners[i], kTracked);
      line(object_from_camera * corners[i], object_from_camera * corners[(i + 1) % 4], kTracked);
    }
  }
  if (state.next_view)
    if (const auto at = pixel(state.next_view->eye)) {
      const float r = 0.4f * overlay_.line_height();
      const Eigen::Vector2f right(r, 0), down(0, r);
      overlay_.triangle(*at - right, *at - down, *at + right, kNext);
      overlay_.triangle(*at - right, *at + right, *at + down, kNext);
      overlay_.text(at->x() + 1.5f * r, at->y() - overlay_.line_height() / 2, "next", kNext);
    }
  overlay_.flush(panel);
}

void ViewerScene::draw_hud(const ViewerState& state, const ViewControls& controls, std::vector<std::string> notes) {
  if (state.snapshot && state.snapshot != counted_) {
    ranks_ = state.snapshot->figures();
    counted_ = state.snapshot;
  }
  for (std::string& note : surface_->notes()) notes.push_back(std::move(note));
  std::optional<Guidance> guidance;
  if (state.snapshot && state.next_view) {
    const Rigid3 here = posed(state) ? state.capture->pose.camera_from_object
                                     : controls.orbit.viewpoint(overlay_.width(), overlay_.height()).camera_from_object;
    guidance = guide(here, bounding_sphere(state.snapshot->mesh()).centre, state.next_view->eye);
  }
  Hud{state, controls, state.snapshot ? &ranks_ : nullptr, guidance ? &*guidance : nullptr, std::move(notes)}.draw(
      overlay_);
}

}  // namespace sheen
