// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/pose_check.h"

#include <Eigen/Dense>

#include "common/base/length_limit.h"

namespace sheen {

std::string make_rotation(Eigen::Matrix3d& matrix) {
  constexpr double kTolerance = 1e-3;
  if (!matrix.allFinite()) return "is not finite";
  const double error = (matrix.transpose() * matrix - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(error <= kTolerance))
    return "is not a rotation: it is not orthonormal (off by " + std::to_string(error) + "); does it contain a scale?";
  if (matrix.determinant() < 0) return "is not a rotation: it is a reflection (its determinant is negative)";
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  matrix = svd.matrixU() * svd.matrixV().transpose();
  return {};
}

std::string place_error(const Eigen::Vector3d& place) {
  if (!place.allFinite()) return "is not finite";
  if (place.cwiseAbs().maxCoeff() > kLongestLength) return "places it beyond 10^9 m";
  return {};
}

}  // namespace sheen
