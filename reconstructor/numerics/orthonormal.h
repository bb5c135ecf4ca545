// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// R = P to_directions is orthonormal, and R coefficients = P but for what rounding hides.
struct Orthonormalised {
  Eigen::MatrixXd to_directions;  ///< columns x directions
  Eigen::MatrixXd coefficients;   ///< directions x columns
};

/// By Cholesky factorization with pivoting. `gram`: P^T P, columns x columns. `norm2`: squared norms of the columns;
/// those of norm 0 are left out. A column that the others explain but for `smallest_pivot` of its energy gives no
/// direction.
Orthonormalised orthonormalise(Eigen::MatrixXd gram, const Eigen::VectorXd& norm2, double smallest_pivot);

/// The rotation of the columns of `leading` (core size x displayed, orthonormal) that moves the old displayed frame
/// (the first `old_displayed` coordinates) least: displayed x displayed, the orthogonal factor of their overlap, by
/// Householder's reflections.
Eigen::MatrixXd aligning_rotation(const Eigen::MatrixXd& leading, Eigen::Index old_displayed);

}  // namespace sheen
