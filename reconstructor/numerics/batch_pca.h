// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>

namespace sheen {

/// Rank-k factorization C ~ B Y of columns that are all at hand: what the online factorization is measured against. As
/// there, columns are not centred.
struct BatchPca {
  Eigen::MatrixXd basis;            ///< B, rows x k, orthonormal
  Eigen::MatrixXd coefficients;     ///< Y, k x columns
  Eigen::VectorXd singular_values;  ///< descending; of all of C, or of B Y where values are missing
  double relative_error = 0;        ///< ||C - B Y|| / ||C||, Frobenius, over known values, columns weighted

  int rank() const { return static_cast<int>(basis.cols()); }
};

/// Best factorization of `columns` (rows x n) of at most `rank` terms in the Frobenius norm (Eckart and Young), from
/// the eigenvectors of the smaller Gram matrix in double precision: singular values below 1e-7 of the largest drown in
/// rounding and are no terms. `weights`: how often a column counts, > 0, n values or none.
/// Throws std::invalid_argument where a value is not finite or a size does not fit.
BatchPca batch_pca(const Eigen::MatrixXf& columns, int rank, std::span<const double> weights = {});

/// The same of double precision.
BatchPca batch_pca_in_double(const Eigen::MatrixXd& columns, int rank, std::span<const double> weights = {});

}  // namespace sheen
