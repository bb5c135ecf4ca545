// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/model_drawer.h"

#include <algorithm>

namespace sheen {

Eigen::Matrix4f clip_from_object(const Viewpoint& view, const BoundingSphere& object) {
  const Camera& c = view.camera;
  const double depth = (view.camera_from_object * object.centre).z();
  const double far = std::max(depth + 1.01 * object.radius, 1e-3 * object.radius);
  const double near = std::max(depth - 1.01 * object.radius, 1e-3 * far);
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  projection(0, 0) = 2 * c.fx / c.width;
  projection(0, 2) = (2 * c.cx + 1) / c.width - 1;
  projection(1, 1) = -2 * c.fy / c.height;
  projection(1, 2) = 1 - (2 * c.cy + 1) / c.height;
  projection(2, 2) = (far + near) / (far - near);
  projection(2, 3) = -2 * far * near / (far - near);
  projection(3, 2) = 1;
  return (projection * view.camera_from_object.matrix()).cast<float>();
}

std::optional<Demand> demand_of(SurfaceShading shading) {
  switch (shading) {
    case SurfaceShading::kRank:
      return Demand::kRank;
    case SurfaceShading::kResolution:
      return Demand::kResolution;
    case SurfaceShading::kBytes:
      return Demand::kBytes;
    default:
      return std::nullopt;
  }
}

Eigen::Vector3f need_color(float need) {
  static const Eigen::Vector3f known(0.18f, 0.66f, 0.38f), some(0.98f, 0.80f, 0.28f), unknown(0.90f, 0.16f, 0.12f);
  const float part = std::clamp(need, 0.0f, 1.0f);
  return part < 0.5f ? Eigen::Vector3f(known + 2 * part * (some - known))
                     : Eigen::Vector3f(some + (2 * part - 1) * (unknown - some));
}

Eigen::Vector3f reason_color(QualityReason reason) {
  switch (reason) {  // told apart by colour-blind people too (Okabe and Ito)
    case QualityReason::kGood:
      return need_color(0);
    case QualityReason::kUnseen:
      return state_color(SampleState::kUnseen);
    case QualityReason::kOblique:
      return {0.90f, 0.62f, 0.00f};
    case QualityReason::kSparseDirections:
      return {0.34f, 0.71f, 0.91f};
    case QualityReason::kHighResidual:
      return {0.94f, 0.89f, 0.26f};
    case QualityReason::kShapeGuessed:
      return evidence_color(ShapeEvidence::kGuessed);
  }
  return {1, 1, 1};
}

}  // namespace sheen
