// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// Largest entry of |B^T B - I|: 0 for a perfectly orthonormal basis.
inline double orthogonality_loss(const Eigen::MatrixXf& basis) {
  const Eigen::MatrixXd b = basis.cast<double>();
  return (b.transpose() * b - Eigen::MatrixXd::Identity(b.cols(), b.cols())).cwiseAbs().maxCoeff();
}

}  // namespace sheen
