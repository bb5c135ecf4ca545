// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/capture/lighting.h"

namespace sheen {

/// A light as surface points see it.
struct Lamp {
  LightKind kind = LightKind::kPoint;
  Eigen::Vector3f place = Eigen::Vector3f::UnitZ();  ///< position, or unit direction
  float strength = 1;                                ///< of a point light 1 m away

  /// From a point to the lamp: all the way to a point light, or a direction of length 1.
  Eigen::Vector3f towards(const Eigen::Vector3f& point) const {
    return kind == LightKind::kPoint ? Eigen::Vector3f(place - point) : place;
  }
  /// Light that arrives at a point, as a vector towards the lamp: with a unit normal n, irradiance is max(0, n.s).
  Eigen::Vector3f incidence(const Eigen::Vector3f& point) const {
    if (kind != LightKind::kPoint) return place;
    const Eigen::Vector3f to = place - point;
    const float squared = std::max(to.squaredNorm(), 1e-12f);
    return to * (strength / (squared * std::sqrt(squared)));
  }
};

/// The lights that a lumigraph was captured in: all directional, or all points.
struct LightSet {
  LightKind kind = LightKind::kPoint;
  Eigen::Matrix3Xd places;  ///< 3 x n: positions (metres), or unit directions towards the lights; object frame

  Eigen::Index size() const { return places.cols(); }
  /// A lamp at this place. A point light is 1 strong as far away as the lights are from the origin, in the mean of
  /// their squares.
  Lamp lamp(const Eigen::Vector3d& place) const;
  Lamp lamp(int light) const { return lamp(Eigen::Vector3d(places.col(light))); }
  /// Where the light of a query is among these. Throws ConfigError for a light of another kind.
  Eigen::Vector3d place_of(const LightState& light) const;

  /// Weights of the lights between which a place lies, up to three: they are at least 0, sum to 1 and bring the
  /// weighted places nearest to it; of several such, those of the nearest lights.
  std::vector<std::pair<int, float>> between(const Eigen::Vector3d& place) const;
};

}  // namespace sheen
