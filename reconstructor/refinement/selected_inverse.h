// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCholesky>

namespace sheen {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Diagonal of A^-1 from the factor of a sparse, symmetric positive definite A = P^T L D L^T P, without forming the
/// inverse: only its entries where L has one are worked out, from the last column to the first (Takahashi, Fagan and
/// Chen 1973; Erisman and Tinney 1975).
Eigen::VectorXd diagonal_of_inverse(const Eigen::SimplicialLDLT<SparseMatrix>& factor);

}  // namespace sheen
