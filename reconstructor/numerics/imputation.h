// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// noise * prior^-1. `prior`: rank x rank, covariance of the coefficients of a column; directions that have hardly been
/// used are given a little. `noise`: variance of a known row, in units of `prior`.
Eigen::MatrixXd prior_precision(const Eigen::MatrixXd& prior, double noise);

/// Most probable coefficients of a column that shows only some rows (maximum a posteriori): minimises
/// ||c_known - B_known y||^2 + y^T precision y. `known`: B_known^T B_known, rank x rank; `projection`: B_known^T
/// c_known. Known rows that show next to nothing of what they ask for do not make a column brighter than a thousand
/// times themselves.
Eigen::VectorXd most_probable_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& known,
                                           const Eigen::Ref<const Eigen::VectorXd>& projection,
                                           const Eigen::MatrixXd& precision);

/// The paper's way (000 sec. 3.2), for comparison: least squares on the known rows alone; of several solutions the one
/// of least Mahalanobis norm, y^T prior^-1 y. Arguments as above; `prior`: covariance of the coefficients of a column.
Eigen::VectorXd least_squares_coefficients(const Eigen::Ref<const Eigen::MatrixXd>& known,
                                           const Eigen::Ref<const Eigen::VectorXd>& projection,
                                           const Eigen::MatrixXd& prior);

/// Coefficients as they are stored. What known rows promise of hidden ones may lie beyond single precision: it ends
/// before, at 5e37.
template <typename Scalar, typename Derived>
auto stored(const Eigen::MatrixBase<Derived>& coefficients) {
  constexpr double kLargest = 5e37;  // the root of 32 terms below what overflows: they may be turned into one
  return coefficients.cwiseMax(-kLargest).cwiseMin(kLargest).template cast<Scalar>();
}

}  // namespace sheen
