// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "common/geometry/ray_scene.h"
#include "common/image/image.h"

namespace sheen {

/// What a camera that stands still sees of an object while its light moves: direct light with exact shadows, one ray
/// per pixel through its centre, no reflections from one surface to another.
class PointLitScene {
 public:
  /// Reflected radiance for an irradiance of pi: of a matt surface its albedo. Unit directions to light and eye.
  using Reflect = std::function<Eigen::Array3f(const Eigen::Vector3f& place, const Eigen::Vector3f& normal,
                                               const Eigen::Vector3f& light, const Eigen::Vector3f& eye)>;

  /// normals: unit, per vertex.
  PointLitScene(const Mesh& mesh, const std::vector<Eigen::Vector3f>& normals, Reflect reflect, PosedCamera camera);

  const PosedCamera& camera() const { return camera_; }
  /// Linear radiance, 3 channels, black where there is no surface: reflect * N.L * rgb, of a point light over the
  /// square of its distance. Throws std::invalid_argument for lights that are neither directional nor a point.
  ImageF picture(const LightState& light) const;
  /// 255 where the light reaches the surface.
  ImageU8 lit(const LightState& light) const;
  /// 255 where there is a surface.
  ImageU8 mask() const;

 private:
  struct Surface {
    bool seen = false;
    Eigen::Vector3f place, normal, flat_normal, eye;
  };
  /// Direction to the light and irradiance over pi of a surface that faces it; zero where it does not arrive.
  struct Arrival {
    Eigen::Vector3f direction;
    float cosine = 0, strength = 0;
  };
  Arrival arrival(const Surface& surface, const LightState& light) const;

  std::shared_ptr<const RayScene> rays_;
  Reflect reflect_;
  PosedCamera camera_;
  float lift_;  ///< of shadow rays off the surface, metres
  std::vector<Surface> surfaces_;
};

}  // namespace sheen
