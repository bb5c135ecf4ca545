// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace sheen {

enum class LightKind : std::uint8_t { kUnspecified = 0, kFixed = 1, kDirectional = 2, kPoint = 3, kEnvironment = 4 };

/// What lit the object while an image was taken.
struct LightState {
  LightKind kind = LightKind::kFixed;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< object frame: metres (point) or unit direction (directional)
  Eigen::Vector3f rgb = Eigen::Vector3f::Ones();
};

/// Whether two lights stand at the same place, or in the same direction, up to rounding (10^-6).
bool same_place(const LightState& a, const LightState& b);
/// The same of positions, or of directions of one length.
bool same_light_place(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace sheen
