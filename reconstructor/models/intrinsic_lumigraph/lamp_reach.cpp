// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/lamp_reach.h"

#include <utility>

namespace sheen {

LampReach::LampReach(const LumigraphData& data, std::shared_ptr<const Occluders> occluders, const Eigen::Vector3d& eye,
                     const Lamp& lamp)
    : occluders_(std::move(occluders)), eye_(eye.cast<float>()), lamp_(lamp) {
  const PosedCamera& near = data.views[views_near(data.views, eye).front().view]->from;
  object_from_camera_ = near.camera_from_object.rotation.conjugate().toRotationMatrix().cast<float>();
  pixel_ = {static_cast<float>(1 / near.camera.fx), static_cast<float>(1 / near.camera.fy)};
}

float LampReach::part(const Eigen::Vector3f& point) const {
  constexpr int kSide = 4;
  const Eigen::Vector3f direction = point - eye_;
  const float depth = object_from_camera_.col(2).dot(direction);
  int surface = 0, lit = 0;
  const auto look = [&](float x, float y) {
    const Ray ray{eye_, direction + depth * (x * pixel_.x() * object_from_camera_.col(0) +
                                             y * pixel_.y() * object_from_camera_.col(1))};
    const Hit hit = occluders_->rays().intersect(ray);
    if (!hit) return;
    ++surface;
    lit += occluders_->reached(occluders_->place_or_none(ray, hit), lamp_);
  };
  for (const float y : {-0.5f, 0.5f})
    for (const float x : {-0.5f, 0.5f}) look(x, y);
  if (surface > 0 && (lit == 0 || lit == surface)) return lit > 0 ? 1 : 0;
  surface = lit = 0;
  for (int k = 0; k < kSide * kSide; ++k)
    look((static_cast<float>(k % kSide) + 0.5f) / kSide - 0.5f, (static_cast<float>(k / kSide) + 0.5f) / kSide - 0.5f);
  return surface > 0 ? static_cast<float>(lit) / static_cast<float>(surface) : 0;
}

}  // namespace sheen
