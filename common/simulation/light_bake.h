// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/ray_scene.h"
#include "common/image/image.h"
#include "common/simulation/stage_surface.h"
#include "common/simulation/studio_lighting.h"
#include "common/simulation/test_object.h"

namespace sheen {

/// How finely the light that falls on the scene is worked out, once.
struct BakeOptions {
  int sky_directions = 2048;    ///< over the sphere; the same everywhere, so that what error there is, is smooth
  int bounce_directions = 512;  ///< over the sphere
  int bounces = 3;
  int area_light_samples = 16;  ///< per side of the emitter
  float stage_cell_m = 0.004f;  ///< grid on the stage
};

/// What the ray tracer needs of a scene: the object, the stage under it (may be absent), the lights.
struct SimulatedScene {
  TestObject object;
  std::optional<StageSurface> stage;
  StudioLighting lighting;
};

/// Irradiance of every vertex of the object and of a grid on the stage, with shadows and interreflection. In what one
/// surface receives from another, a glossy lobe counts as diffuse reflection of the same strength.
class LightBake {
 public:
  LightBake(const SimulatedScene& scene, const RayScene& rays, const BakeOptions& options);

  /// Irradiance at a place on a triangle (W/m^2 up to the scene's scale), interpolated.
  Eigen::Array3f object_irradiance(const Hit& hit) const { return interpolate(object_irradiance_, hit); }
  /// Radiance that leaves the object there, all its reflection taken as diffuse.
  Eigen::Array3f object_radiance(const Hit& hit) const { return interpolate(object_radiance_, hit); }
  Eigen::Array3f stage_irradiance(float x, float y) const { return interpolate(stage_irradiance_, x, y); }
  /// Radiance that leaves the stage there, its print blurred to the grid; zero beyond the table.
  Eigen::Array3f stage_radiance(float x, float y) const { return interpolate(stage_radiance_, x, y); }

  /// Radiance that arrives at a point of the object along rays with unit directions, no more than `LobePoints::kCount`.
  void incoming(std::span<const Ray> rays, std::span<Eigen::Array3f> radiance) const;

 private:
  struct Point {
    Eigen::Vector3f position, normal;
  };
  /// What a ray from a surface meets first.
  struct Meeting {
    Hit object;
    std::optional<Eigen::Vector2f> stage;
  };
  Meeting meet(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
  std::optional<Eigen::Vector2f> meet_stage(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
  bool misses_object(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
  Eigen::Array3f reflected(const Meeting& meeting) const;
  Eigen::Array3f gather_lights(const Point& point, const BakeOptions& options) const;
  Eigen::Array3f gather_reflections(const Point& point) const;
  void update_outgoing();
  Eigen::Array3f interpolate(const std::vector<Eigen::Array3f>& values, const Hit& hit) const;
  Eigen::Array3f interpolate(const ImageF& grid, float x, float y) const;
  Point stage_point(int column, int row) const;

  const SimulatedScene& scene_;
  const RayScene& rays_;
  BoundingSphere bounds_;
  float stage_cell_, stage_half_;
  std::vector<Eigen::Vector3f> sky_directions_, bounce_directions_;
  std::vector<Eigen::Array3f> sky_radiance_;
  std::vector<Eigen::Array3f> object_albedo_, object_irradiance_, object_radiance_;
  ImageF stage_albedo_, stage_irradiance_, stage_radiance_;
};

}  // namespace sheen
