// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace sheen {

/// In radians: `30 * kDegree` is an angle of 30 degrees, `angle / kDegree` is an angle in degrees.
inline constexpr double kDegree = std::numbers::pi / 180;

}  // namespace sheen
