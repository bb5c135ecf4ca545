// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "reconstructor/numerics/row_panels.h"

namespace sheen {

/// Most probable coefficients of columns that show only some rows (maximum a posteriori): column j minimises
/// ||c_known - B_known y||^2 + noise * y^T prior^-1 y. Columns that show all rows get their projection.
///
/// basis: orthonormal columns. hidden: a row; bit j is set when column j does not show it (at most 32 columns).
/// projections: B^T C, rank x columns, with zeros in C where hidden. prior: rank x rank, covariance of the coefficients
/// of a column. noise: variance of a known row, in units of `prior`.
///
/// B_known^T B_known is summed over rows that are hidden in the same columns, so it costs one Gram matrix of the basis
/// for all columns where they hide the same places; over the hidden rows (I minus) or the known ones, whichever are
/// fewer.
template <typename Scalar>
Eigen::MatrixXd most_probable_coefficients(const row_panels::Columns<const Scalar>& basis,
                                           std::span<const std::uint32_t> hidden, const Eigen::MatrixXd& projections,
                                           const Eigen::MatrixXd& prior, double noise);

}  // namespace sheen
