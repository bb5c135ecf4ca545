// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/image/image.h"
#include "common/simulation/light_bake.h"

namespace sheen {

/// Directions of a camera's pixel corners, worked out through its lens once. Throws ConfigError where the lens folds.
class LensRays {
 public:
  explicit LensRays(const Camera& camera);
  const Camera& camera() const { return camera_; }
  /// Direction in camera coordinates with z = 1 of a pixel position, integer at pixel centres.
  Eigen::Vector3f direction(float x, float y) const;

 private:
  Camera camera_;
  std::vector<Eigen::Vector2f> corners_;  ///< (width + 1) x (height + 1), at half-integer positions
};

/// A lamp that is a point, beside what lights the scene: so its light arrives with hard shadows, and what one surface
/// reflects of it to another is left out.
struct PointLamp {
  Eigen::Vector3f position;  ///< metres
  Eigen::Array3f power;      ///< irradiance of a surface that faces it from one metre
};

struct RenderOptions {
  int object_samples = 4;  ///< primary rays per pixel on the object
  int edge_samples = 16;   ///< primary rays per pixel that an edge crosses
  int lobe_samples = 64;   ///< rays per pixel into the glossy lobe, shared among its primary rays
  std::optional<PointLamp> lamp;
  float lighting = 1;  ///< factor of what lights the scene without the lamp
};

/// Linear radiance (3 channels) as a box filter over each pixel sees it, and the object's silhouette: 255 where the ray
/// through the pixel's centre meets the object.
struct RenderedView {
  ImageF radiance;
  ImageU8 mask;
};

/// Renders a scene from anywhere. The diffuse light is baked when the tracer is made; the glossy lobe is sampled for
/// each pixel with the same points in every frame. Deterministic: the same call gives the same bits. Const calls are
/// thread-safe.
class PathTracer {
 public:
  explicit PathTracer(SimulatedScene scene, const BakeOptions& bake = {});

  const SimulatedScene& scene() const { return *scene_; }
  const LightBake& light() const { return *bake_; }

  RenderedView render(const LensRays& lens, const Rigid3& camera_from_object, const RenderOptions& options = {}) const;

  /// Radiance along one ray, its lobe sampled with `lobe_samples` rays.
  Eigen::Array3f radiance(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, int lobe_samples) const;

 private:
  struct Surface;
  /// A primary ray's part of the points from which the lobe is sampled.
  using LobeShare = std::span<const LobePoints>;
  Surface first_surface(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
  Eigen::Array3f shade(const Surface& surface, const Eigen::Vector3f& direction, LobeShare share) const;
  Eigen::Array3f lamp_irradiance(const PointLamp& lamp, const Eigen::Vector3f& place, const Eigen::Vector3f& normal,
                                 Eigen::Vector3f& towards) const;
  Eigen::Array3f shade_by_lamp(const Surface& surface, const Eigen::Vector3f& direction, const PointLamp& lamp) const;
  Eigen::Vector3f shading_normal(const Hit& hit, const Eigen::Vector3f& eye) const;
  Eigen::Array3f shade_object(const Hit& hit, const Eigen::Vector3f& position, const Eigen::Vector3f& direction,
                              LobeShare share) const;

  std::unique_ptr<const SimulatedScene> scene_;  ///< stays where it is: the bake refers to it
  std::unique_ptr<const RayScene> rays_;
  std::unique_ptr<const LightBake> bake_;
  BoundingSphere bounds_;
};

}  // namespace sheen
