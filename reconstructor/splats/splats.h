// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace sheen {

/// A Gaussian in space.
struct SplatShape {
  Eigen::Vector3f centre;     ///< object frame, metres
  Eigen::Quaternionf turn;    ///< of its axes
  Eigen::Vector3f deviation;  ///< standard deviation along each axis, metres
  float opacity = 1;          ///< at its centre, 0..1

  Eigen::Matrix3f covariance() const {
    const Eigen::Matrix3f axes = turn.toRotationMatrix() * deviation.asDiagonal();
    return axes * axes.transpose();
  }
};

inline constexpr int kMostSplatDegree = 3;  ///< that the viewers know

/// Gaussians with a colour for each direction, as the viewers of 3-D Gaussian splatting (Kerbl et al. 2023) show them:
/// encoded (sRGB) 0.5 + sum of harmonics, laid over each other from the front.
struct Splats {
  int degree = kMostSplatDegree;
  std::vector<SplatShape> shapes;
  /// 3 terms x splats: of each splat all terms of red, then green, then blue.
  Eigen::MatrixXf colours;

  int terms() const { return (degree + 1) * (degree + 1); }
  /// Colour channel of a splat: its terms.
  auto channel(std::size_t splat, int c) { return colours.col(Eigen::Index(splat)).segment(c * terms(), terms()); }
  auto channel(std::size_t splat, int c) const {
    return colours.col(Eigen::Index(splat)).segment(c * terms(), terms());
  }
};

/// The first `terms` harmonics with the viewers' signs (Condon-Shortley), at the unit direction from the eye to a
/// splat.
Eigen::VectorXf splat_harmonics(const Eigen::Vector3f& direction, int terms);

}  // namespace sheen
