// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace sheen {

/// A = vectors diag(values) vectors^T
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< descending
  Eigen::MatrixXd vectors;  ///< orthonormal columns
};

/// All eigenvalues and eigenvectors of a symmetric matrix of some tens of rows, to rounding of its norm: as a general
/// solver does, with vector instructions and without waiting, for every fold of the online SVD asks for them.
/// Householder's tridiagonal form, then QL steps in pairs (Parlett, The Symmetric Eigenvalue Problem, chapters 7 and
/// 8). What is not finite gives nothing that is.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);

}  // namespace sheen
