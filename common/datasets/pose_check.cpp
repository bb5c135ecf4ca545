// SPDX-License-Identifier: Apache-2.0
#include "common/datasets/pose_check.h"

#include <Eigen/Dense>

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

}  // namespace sheen
