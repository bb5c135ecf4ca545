// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "reconstructor/numerics/row_panels.h"

namespace sheen {

inline constexpr int kPatternColumns = 64;  ///< columns whose known flags fit into one word per row

/// B_known^T B_known of columns that show only some rows: rank^2 x columns, one matrix per column.
///
/// basis: orthonormal columns. hidden: a row; bit j is set when column j does not show it.
///
/// Rows that are hidden in the same columns are summed once, so it costs one Gram matrix of the basis and the sums of
/// those that a column chooses: over its hidden rows (I minus) or its known ones, whichever are fewer.
template <typename Scalar>
Eigen::MatrixXd known_grams(const row_panels::Columns<const Scalar>& basis, std::span<const std::uint64_t> hidden,
                            int columns);

}  // namespace sheen
