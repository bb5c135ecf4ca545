// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// Largest entry of |B^T B - I|: 0 for a perfectly orthonormal basis.
template <typename Derived>
double orthogonality_loss(const Eigen::MatrixBase<Derived>& basis) {
  const Eigen::MatrixXd b = basis.template cast<double>();
  return (b.transpose() * b - Eigen::MatrixXd::Identity(b.cols(), b.cols())).cwiseAbs().maxCoeff();
}

}  // namespace sheen
