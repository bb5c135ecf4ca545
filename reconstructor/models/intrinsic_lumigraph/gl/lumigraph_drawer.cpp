// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/gl/lumigraph_drawer.h"

#include <algorithm>

#include "common/image/color.h"

namespace sheen {
namespace {

/// The pictures have no light from below the horizon.
Eigen::Vector3d above_horizon(const Eigen::Vector3d& direction) {
  constexpr double kLowest = 0.02;
  return Eigen::Vector3d(direction.x(), direction.y(), std::max(direction.z(), kLowest)).normalized();
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
  if (!viewpoint.light.isZero()) light.position = light.position.norm() * above_horizon(viewpoint.light);
  refresh(viewpoint, light);
  const bool needs = shading == SurfaceShading::kHeuristic || shading == SurfaceShading::kReasons;
  TexturedPanel::Look look{.black_is_empty = true};
  if (needs) look.color = need_color(static_cast<float>(model.data()->error / 0.1));
  picture_.draw(area.panel, area.target_height, look);
}

}  // namespace sheen
