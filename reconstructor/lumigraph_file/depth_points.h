// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>

#include "common/camera/posed_camera.h"
#include "common/image/image.h"
#include "common/parallel/for_each.h"

namespace sheen {

/// Points of the object by pixel and depth.
class DepthPoints {
 public:
  explicit DepthPoints(const PosedCamera& from)
      : camera_(from.camera),
        object_from_camera_(from.camera_from_object.rotation.conjugate().toRotationMatrix().cast<float>()),
        eye_(camera_centre(from.camera_from_object).cast<float>()) {}
  /// `depth`: z in camera coordinates. The eye itself where the lens has no ray.
  Eigen::Vector3f at(double x, double y, float depth) const { return eye_ + depth * direction(x, y); }
  /// Of the ray through a place of the picture, z in camera coordinates being 1; object frame.
  Eigen::Vector3f direction(double x, double y) const {
    if (camera_.is_pinhole())
      return object_from_camera_ * Eigen::Vector3f(static_cast<float>((x - camera_.cx) / camera_.fx),
                                                   static_cast<float>((y - camera_.cy) / camera_.fy), 1);
    const auto ray = camera_.ray({x, y});
    if (!ray || !(ray->z() > 0)) return Eigen::Vector3f::Zero();
    return object_from_camera_ * (*ray / ray->z()).cast<float>();
  }
  const Eigen::Vector3f& eye() const { return eye_; }

 private:
  Camera camera_;
  Eigen::Matrix3f object_from_camera_;
  Eigen::Vector3f eye_;
};

/// Calls `visit(pixel, point)` for all pixels, a row at a time; without depth the point is the eye.
void for_each_point(const PosedCamera& from, const ImageF& depth, const ForEach& for_each,
                    const std::function<void(std::size_t, const Eigen::Vector3f&)>& visit);

}  // namespace sheen
