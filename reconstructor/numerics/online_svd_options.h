// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// What stands for the rows that a column does not show.
enum class Imputation {
  kMostProbable,  ///< with a prior, and again as the basis learns (docs/decisions/missing_samples.md)
  kLeastSquares,  ///< the paper's (000 sec. 3.2), for comparison: once, when the column is folded
};

/// When the online SVD grows, and how far.
struct OnlineSvdOptions {
  int max_rank = 24;           ///< terms displayed, >= 1
  int internal_rank = 0;       ///< terms kept, >= max_rank; 0 = 2 * max_rank, at least max_rank + 8, at most 32 (Brand)
  int block = 12;              ///< columns buffered between folds, 1..32; fewer while there are few
  double tolerance = 0.01;     ///< Frobenius norm of what may be lost, relative to that of all columns: eps
  int channels = 1;            ///< of a plane: rows i, i + channels, ... hold the same quantity at different places
  double sensor_variance = 0;  ///< of a known row, in squared units of the columns: imputation never trusts one more
  Imputation imputation = Imputation::kMostProbable;
  double residual_memory = 0.8;  ///< of the running mean of what the basis leaves unexplained per row (`row_noise`)

  int terms_kept() const;
  /// Of the rows of a factor: those of which every view that hides rows remembers what it showed.
  int witnesses(int rows) const;
  /// These, with at most so many terms and columns per block.
  OnlineSvdOptions limited_to(int most_displayed, int most_kept, int most_in_block) const;
};

/// Throws std::invalid_argument naming the rule that the options break for a factor of so many rows.
void require_valid(const OnlineSvdOptions& options, int rows);

}  // namespace sheen
