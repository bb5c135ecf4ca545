// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/gl/lumigraph_drawer.h"

#include <algorithm>
#include <cmath>

#include "common/image/color.h"

namespace sheen {
namespace {

/// Turned round the object's z axis, and up as far as the zenith or the horizon.
Eigen::Vector3d turned_light(const Eigen::Vector3d& place, const Eigen::Vector2d& rotation) {
  const double azimuth = std::atan2(place.y(), place.x()) + rotation.x(),
               elevation = std::clamp(std::asin(place.normalized().z()) + rotation.y(), 0.02, M_PI / 2);
  return place.norm() * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
}

}  // namespace

bool LumigraphDrawer::update(const std::shared_ptr<const ModelSnapshot>& snapshot) {
  const auto model = std::dynamic_pointer_cast<const IntrinsicLumigraphSnapshot>(snapshot);
  if (painter_ && painter_->model() == model) return true;
  painter_.reset();
  if (model) painter_.emplace(model);
  shown_from_.reset();
  return true;
}

std::vector<std::string> LumigraphDrawer::notes() const {
  return {"Ctrl and drag: turn the light"};
}

void LumigraphDrawer::refresh(const Viewpoint& viewpoint, const LightState& light) {
  if (shown_from_ && *shown_from_ == viewpoint) return;
  picture_.upload(to_srgb8(painter_->paint({viewpoint.camera, viewpoint.camera_from_object}, light)),
                  TexturedPanel::Scaling::kNone);
  shown_from_ = viewpoint;
}

void LumigraphDrawer::draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) {
  if (!painter_ || painter_->model()->empty()) return;
  const IntrinsicLumigraphSnapshot& model = *painter_->model();
  LightState light{.kind = model.light_kind(), .position = model.light_place({})};
  light.position = turned_light(light.position, viewpoint.light_rotation);
  refresh(viewpoint, light);
  const bool needs = shading == SurfaceShading::kHeuristic || shading == SurfaceShading::kReasons;
  TexturedPanel::Look look{.black_is_empty = true};
  if (needs) look.color = need_color(static_cast<float>(model.data()->error / 0.1));
  picture_.draw(area.panel, area.target_height, look);
}

}  // namespace sheen
