// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

namespace sheen {

/// target = scale * rotation * source + translation.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return scale * (rotation * point) + translation; }
};

/// The one that fits best in the sense of weighted least squares (Umeyama 1991). Weights empty: all alike. Needs three
/// points that are not on one line.
Similarity fit_similarity(std::span<const Eigen::Vector3d> source, std::span<const Eigen::Vector3d> target,
                          std::span<const double> weights = {});

}  // namespace sheen
