// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/gl/field_drawer.h"

#include <algorithm>

namespace sheen {

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
  picture_.upload(shown_->screen_picture(light), TexturedPanel::Scaling::kSmooth);
  lit_from_ = from;
}

void FieldDrawer::draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) {
  if (!shown_ || shown_->empty()) return;
  const Eigen::Vector3d towards_eye = (viewpoint.eye() - bounding_sphere(shown_->mesh()).centre).normalized();
  relight(viewpoint.light.isZero() ? towards_eye : viewpoint.light);
  const bool needs = shading == SurfaceShading::kHeuristic || shading == SurfaceShading::kReasons;
  TexturedPanel::Look look;
  if (needs) look.color = need_color(static_cast<float>(shown_->scene().error / 0.1));
  const auto& size = shown_->field().size;
  picture_.draw(fit(area.panel, size.width, size.height), area.target_height, look);
}

}  // namespace sheen
