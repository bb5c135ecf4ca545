// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>

namespace sheen {

/// A one-sided rectangular emitter.
struct AreaLight {
  Eigen::Vector3f centre, half_u, half_v;  ///< metres; it shines along half_u x half_v
  Eigen::Array3f radiance{1, 1, 1};
  /// Part of each half side over which the emission falls to zero, as a softbox's does; 0 is a uniform emitter.
  float falloff = 0;

  Eigen::Vector3f normal() const;
  float area() const;
  /// Emission relative to `radiance` at (a, b) in [-1, 1]^2 of the rectangle.
  float profile(float a, float b) const;

  /// Where a ray meets its shining side.
  struct Crossing {
    float distance;  ///< in multiples of the direction
    float emission;  ///< 0..1, see `profile`
  };
  std::optional<Crossing> meet(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
};

/// What lights a scene: radiance from infinitely far, by unit direction, and perhaps an area light.
struct StudioLighting {
  std::function<Eigen::Array3f(const Eigen::Vector3f&)> environment;
  std::optional<AreaLight> area_light;
};

/// The demo's studio: a soft room with three softboxes far off and a large one near the stage.
StudioLighting make_studio();

/// The same radiance from everywhere and nothing else.
StudioLighting make_uniform_lighting(const Eigen::Array3f& radiance);

}  // namespace sheen
