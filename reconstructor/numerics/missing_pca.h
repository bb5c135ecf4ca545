// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "reconstructor/numerics/batch_pca.h"

namespace sheen {

/// For each row and column, whether the value is known: 0 where it is missing. Missing values are never read.
using KnownValues = Eigen::Array<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic>;

struct MissingPcaOptions {
  int max_iterations = 300;
  double convergence = 1e-5;  ///< change of the surprise (nats per known value) at which the iteration ends
  double noise = 0;           ///< variance of a known value; 0 = the most probable one
};

/// Most probable factorization where values are missing: probabilistic PCA (c = W x + noise, x standard normal, the
/// noise the same everywhere; Tipping and Bishop 1999) by expectation maximisation over the known values, started from
/// rows filled with their means. Rows and columns of which nothing is known are zero. With nothing missing it agrees
/// with `batch_pca` as far as the noise allows (coefficients shrink by noise / variance). Throws as `batch_pca`.
BatchPca batch_pca_missing(const Eigen::MatrixXf& columns, const KnownValues& known, int rank,
                           std::span<const double> weights = {}, const MissingPcaOptions& options = {});

/// What the online factorization would be if it had all columns at hand from the start: missing values are imputed with
/// the most probable factorization of `imputing_rank` terms (its internal rank), and of the completed columns the
/// leading `rank` terms are kept. Columns with missing values have the coefficients that are most probable with these
/// terms alone, as `OnlineSvd::displayed_coefficients`. With nothing missing it is `batch_pca`. Throws as `batch_pca`.
BatchPca batch_pca_imputed(const Eigen::MatrixXf& columns, const KnownValues& known, int rank, int imputing_rank,
                           std::span<const double> weights = {}, const MissingPcaOptions& options = {});

/// How badly a basis (rows x k, orthonormal columns) explains what is known: mean of -log likelihood for each known
/// value, in nats, at the covariance of the coefficients that suits the basis best, and at this noise (0 = the one that
/// suits it best). It is what `batch_pca_missing` makes least among all bases of k columns.
double surprise(const Eigen::MatrixXf& columns, const KnownValues& known, const Eigen::MatrixXd& basis,
                std::span<const double> weights = {}, double noise = 0);

}  // namespace sheen
