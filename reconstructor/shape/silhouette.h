// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "common/geometry/ray_scene.h"
#include "reconstructor/shape/shape_view.h"

namespace sheen {

/// Of a mesh in a view: asks of pixels whether it is there. View and scene must outlive it.
class Silhouette {
 public:
  Silhouette(const ShapeView& view, const RayScene& scene, const Eigen::Vector3d& origin)
      : scene_(scene), camera_(view.camera.camera), object_from_view_(view.camera.camera_from_object.inverse()) {
    eye_ = (object_from_view_.translation - origin).cast<float>();
  }
  bool has(int x, int y) const {
    const Eigen::Vector3d ray((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1);
    return scene_.occluded({.origin = eye_, .direction = (object_from_view_.rotation * ray).cast<float>()});
  }

 private:
  const RayScene& scene_;
  const Camera& camera_;
  Rigid3 object_from_view_;
  Eigen::Vector3f eye_;
};

}  // namespace sheen
