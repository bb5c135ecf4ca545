// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "tracker/lights/ball_view.h"

namespace sheen {

/// An edge across one of the rays from a ball's middle, pixels.
struct RimPoint {
  std::size_t ray;
  Eigen::Vector2d at;
};

/// Whether the picture has a pixel.
using Shown = std::function<bool(const Eigen::Vector2d&)>;

/// A circle that edges agree with.
struct RimCircle {
  BallCircle circle;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of centre and radius, px^2
  double visible = 0;                                    ///< part of it that lies in the picture
  double support = 0;                                    ///< part of that which has an edge
};

inline constexpr double kRimSearch =
    0.3;  ///< of the radius: how far centre and radius may be from where they are sought

/// Least squares of the circle that most edges agree with. Of several that agree nearly as well the largest: a mirror's
/// reflections make circles inside its outline. Empty where there is none.
std::optional<RimCircle> fit_rim(const std::vector<RimPoint>& edges, std::size_t rays, const BallCircle& about,
                                 const Shown& shown);

}  // namespace sheen
