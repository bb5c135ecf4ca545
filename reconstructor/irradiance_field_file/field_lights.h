// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "common/capture/lighting.h"
#include "reconstructor/irradiance_field_file/lit_scene.h"

namespace sheen {

/// Between the lights of a scene's images.
class FieldLights {
 public:
  /// There must be lights.
  explicit FieldLights(const LitScene& scene);

  /// The light that the kriging knows, with the brightness of the one that is asked for. Where near lights moved on a
  /// plane, a light off it is taken for the one on it that the object's origin sees in the same direction, weaker by
  /// the squares of their distances; a far light is as bright there as a lamp at the plane's nearest place. Throws
  /// ConfigError for any other light of another kind than those of the images.
  LightState known(const LightState& light) const;
  /// Weights of the images in the picture that a known light gives, but for its colour: the kriging's, which fade to a
  /// mean of the nearest lights far beyond all of them.
  Eigen::VectorXf weights(const LightState& known) const;

  const PointKriging& kriging() const { return kriging_; }

 private:
  LightKind kind_;
  Eigen::Matrix3Xd lights_;
  PointKriging kriging_;
  std::optional<LightPlane> plane_;
};

}  // namespace sheen
