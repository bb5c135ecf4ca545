// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/viewer_scene.h"

#include <algorithm>
#include <cmath>

#include "common/base/angle.h"
#include "common/base/format.h"
#include "reconstructor/render/gl/light_ball.h"
#include "reconstructor/render/nearest_photograph.h"

namespace sheen {
namespace {

constexpr Rgba kTracked{255, 215, 90, 255}, kNext{90, 220, 120, 255}, kDivider{90, 95, 105, 255};
constexpr float kDividerWidth = 2;

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

/// Before there is anything of a model to see, the camera's image is shown.
ViewMode shown_mode(const ViewerState& state, const ViewControls& controls) {
  return !state.snapshot && state.capture ? ViewMode::kCamera : controls.mode;
}

const Mesh* mesh_of(const ViewerState& state) {
  return state.snapshot ? &state.snapshot->mesh() : nullptr;
}

/// Where no image is in a light from about there: how far the nearest is; else empty.
std::string no_light_note(const ShownLight& light) {
  constexpr double kFarDeg = 15;
  double most = -1;
  for (const Eigen::Vector3d& image : light.images) most = std::max(most, image.dot(light.now));
  const double away_deg = std::acos(std::min(1.0, most)) / kDegree;
  if (away_deg <= kFarDeg) return {};
  return format("no image in light from here: the nearest is %.0f degrees away", away_deg);
}

/// Of a panel, what lies in these rows; nothing may be left.
Panel in_rows(const Panel& panel, int top, int rows) {
  const int first = std::max(panel.y, top), end = std::min(panel.y + panel.height, top + rows);
  return {panel.x, first, panel.width, std::max(0, end - first)};
}

}  // namespace

std::vector<ViewerScene::SurfacePanel> ViewerScene::surface_panels(const ViewerState& state,
                                                                   const ViewControls& controls, int width,
                                                                   int height) {
  std::vector<SurfacePanel> panels;
  if (!state.snapshot) return panels;
  const SurfaceShading need = controls.reasons ? SurfaceShading::kReasons : SurfaceShading::kHeuristic;
  const SurfaceShading seen = controls.states           ? SurfaceShading::kStates
                              : state.snapshot->empty() ? SurfaceShading::kPlain
                                                        : SurfaceShading::kAppearance;
  const auto add = [&](const Panel& area, SurfaceShading shading) {
    const bool follow = controls.follow && posed(state);
    const Panel panel = follow ? fit(area, state.capture->camera.width, state.capture->camera.height) : area;
    Viewpoint viewpoint =
        follow ? tracked_viewpoint(*state.capture, panel) : controls.orbit.viewpoint(panel.width, panel.height);
    viewpoint.light = controls.light;
    panels.push_back({panel, viewpoint, shading});
  };
  const int half = std::max(1, width / 2);
  switch (controls.mode) {
    case ViewMode::kAppearance:
      add({0, 0, width, height}, seen);
      break;
    case ViewMode::kHeuristic:
      add({0, 0, width, height}, need);
      break;
    case ViewMode::kSplit:
      add({0, 0, half, height}, seen);
      add({width - half, 0, half, height}, need);
      break;
    case ViewMode::kCamera:
      break;
    case ViewMode::kRank:
      add({0, 0, width, height}, SurfaceShading::kRank);
      break;
    case ViewMode::kResolution:
      add({0, 0, width, height}, SurfaceShading::kResolution);
      break;
    case ViewMode::kBytes:
      add({0, 0, width, height}, SurfaceShading::kBytes);
      break;
    case ViewMode::kShape:
      add({0, 0, width, height}, SurfaceShading::kShape);
      break;
  }
  return panels;
}

void ViewerScene::draw_rows(const ViewerState& state, const ViewControls& controls, const RenderTarget& target, int top,
                            int rows) {
  if (top == 0) target.clear(color_of(controls.ground));
  target.draw_on();
  for (const SurfacePanel& surface : surface_panels(state, controls, target.width(), target.height())) {
    const ScissorScope scissor(in_rows(surface.panel, top, rows), target.height());
    surface_->draw(surface.viewpoint, {surface.panel, target.height()}, surface.shading);
  }
  if (shown_mode(state, controls) == ViewMode::kCamera && state.capture) {
    const Panel panel =
        fit({0, 0, target.width(), target.height()}, state.capture->camera.width, state.capture->camera.height);
    const ScissorScope scissor(in_rows(panel, top, rows), target.height());
    camera_.draw(state.capture, mesh_of(state), panel, target.height());
  }
}

void ViewerScene::draw_coarse(const ViewerState& state, const ViewControls& controls, const RenderTarget& coarse,
                              const RenderTarget& target) {
  target.clear_picture(color_of(controls.ground));
  for (const SurfacePanel& surface : surface_panels(state, controls, target.width(), target.height())) {
    const auto part = [](int size, int of, int whole) {
      return std::clamp(static_cast<int>(std::lround(double(size) * of / whole)), 1, of);
    };
    const Panel small{0, 0, part(surface.panel.width, coarse.width(), target.width()),
                      part(surface.panel.height, coarse.height(), target.height())};
    Viewpoint viewpoint = surface.viewpoint;
    viewpoint.camera = viewpoint.camera.scaled(small.width, small.height);
    coarse.clear(color_of(controls.ground));
    surface_->draw(viewpoint,
                   {small, coarse.height(), static_cast<float>(surface.panel.width) / static_cast<float>(small.width)},
                   surface.shading);
    coarse.resolve();
    target.enlarge(coarse, small, surface.panel);
  }
}

std::vector<Sketch> ViewerScene::sketches(const ViewerState& state, const ViewControls& controls, int width,
                                          int height) {
  std::vector<Sketch> all;
  if (shown_mode(state, controls) == ViewMode::kCamera) {
    if (state.capture)
      all.push_back(CameraPicture::annotations(
          *state.capture, mesh_of(state),
          fit({0, 0, width, height}, state.capture->camera.width, state.capture->camera.height)));
    return all;
  }
  if (controls.panels && !(controls.follow && posed(state)))
    for (const SurfacePanel& surface : surface_panels(state, controls, width, height))
      all.push_back(guides(state, surface));
  if (controls.mode == ViewMode::kSplit) {
    const float middle = static_cast<float>(width) / 2;
    all.push_back({.clip = {0, 0, width, height},
                   .lines = {{{middle, 0}, {middle, static_cast<float>(height)}, kDividerWidth, kDivider}}});
  }
  return all;
}

/// Where the tracked camera is and where it should go, in the free camera's picture.
Sketch ViewerScene::guides(const ViewerState& state, const SurfacePanel& surface) {
  const auto& [panel, viewpoint, shading] = surface;
  Sketch sketch{.clip = panel};
  const Eigen::Vector2f origin(static_cast<float>(panel.x) + 0.5f, static_cast<float>(panel.y) + 0.5f);
  const auto pixel = [&, &view = viewpoint](const Eigen::Vector3d& point) -> std::optional<Eigen::Vector2f> {
    const auto p = view.camera.project(view.camera_from_object * point);
    if (!p) return std::nullopt;
    return p->cast<float>() + origin;
  };
  const auto line = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const auto from = pixel(a), to = pixel(b);
    if (from && to) sketch.lines.push_back({*from, *to, 1.5f, kTracked});
  };
  if (posed(state)) {
    const double size = 0.35 * bounding_sphere(state.snapshot->mesh()).radius;
    const Camera& camera = state.capture->camera;
    const Rigid3 object_from_camera = state.capture->pose.camera_from_object.inverse();
    const double x = 0.5 * camera.width / camera.fx * size, y = 0.5 * camera.height / camera.fy * size;
    const Eigen::Vector3d corners[4] = {{-x, -y, size}, {x, -y, size}, {x, y, size}, {-x, y, size}};
    for (int i = 0; i < 4; ++i) {
      line(object_from_camera.translation, object_from_camera * corners[i]);
      line(object_from_camera * corners[i], object_from_camera * corners[(i + 1) % 4]);
    }
  }
  if (state.next_view && !state.next_view->well_known)
    if (const auto at = pixel(state.next_view->eye)) sketch.marks.push_back({*at, "next", kNext});
  return sketch;
}

const DemandMap& ViewerScene::demand_map(const std::shared_ptr<const ModelSnapshot>& snapshot, Demand demand) {
  if (!demand_ || demand_->of != demand || demand_->snapshot != snapshot)
    demand_ = ShownDemand{demand, snapshot, DemandMap(*snapshot, demand)};
  return demand_->map;
}

Told ViewerScene::told(const ViewerState& state, const ViewControls& controls, std::vector<std::string> notes,
                       int width, int height) {
  if (state.snapshot && state.snapshot != counted_) {
    figures_ = state.snapshot->figures();
    counted_ = state.snapshot;
  }
  const auto panels = surface_panels(state, controls, width, height);
  const ViewMode mode = shown_mode(state, controls);
  if (mode == ViewMode::kCamera && !state.capture) notes.push_back("no camera image");
  if (mode != ViewMode::kCamera && !state.snapshot && !state.work) notes.push_back("no model");
  if (mode != ViewMode::kCamera && controls.follow && !posed(state)) notes.push_back("no tracked camera to follow");
  for (std::string& note : surface_->notes()) notes.push_back(std::move(note));
  if (!panels.empty() && surface_->follows_eye()) {
    const std::string note = no_photograph_note(*state.snapshot, panels.front().viewpoint.eye());
    if (!note.empty()) notes.push_back(note);
  }
  std::optional<Guidance> guidance;
  if (state.snapshot && state.next_view) {
    const Rigid3 here = posed(state) ? state.capture->pose.camera_from_object
                                     : controls.orbit.viewpoint(width, height).camera_from_object;
    guidance = guide(here, bounding_sphere(state.snapshot->mesh()).centre, state.next_view->eye);
  }
  const DemandMap* demand = nullptr;
  if (const std::optional<Demand> shown = demand_of(controls.mode); shown && state.snapshot)
    demand = &demand_map(state.snapshot, *shown);
  if (demand && demand->empty()) notes.push_back("this kind of model has no patches");
  std::optional<ShownLight> light;
  if (state.snapshot && !controls.light.isZero() && !panels.empty()) {
    const Eigen::Matrix3d axes = picture_axes(panels.front().viewpoint.camera_from_object);
    light = ShownLight{axes, axes * controls.light, light_directions(*state.snapshot)};
    for (Eigen::Vector3d& direction : light->images) direction = axes * direction;
    if (const std::string note = no_light_note(*light); !note.empty()) notes.push_back(note);
  }
  ViewControls shown = controls;
  shown.mode = mode;
  Told all = sheen::told(state, shown,
                         {.model = model_,
                          .figures = state.snapshot ? &figures_ : nullptr,
                          .demand = demand,
                          .guidance = guidance ? &*guidance : nullptr},
                         std::move(notes));
  all.light = std::move(light);
  return all;
}

}  // namespace sheen
