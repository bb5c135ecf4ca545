// SPDX-License-Identifier: Apache-2.0
// The goals of the factorization, a file a theme; measure_numerics.cpp puts them in order.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <vector>

#include "common/base/order_statistics.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/bench/goal_rows.h"

namespace sheen {

/// Time of an update in the cache, of an image over 3,500 patches, float against double.
void measure_speed(GoalReport& report);
/// Error over the batch's in 23 orders, adaptive rank, self-reported error, half-precision storage.
void measure_accuracy(GoalReport& report);
/// Streams of which columns are occluded: most probable values against the paper's gated least squares.
void measure_missing(GoalReport& report);
/// What time does: a million columns, continuity of coefficients, removal, bytes.
void measure_history(GoalReport& report);

inline constexpr int kDisplayed = 12;  ///< terms of the goals

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The factor of all columns, settled.
inline OnlineSvd factor_of(const Eigen::MatrixXf& columns, const OnlineSvdOptions& options) {
  OnlineSvd factor(static_cast<int>(columns.rows()), options);
  for (Eigen::Index j = 0; j < columns.cols(); ++j) factor.add(columns.col(j));
  factor.fold();
  return factor;
}

/// ||C - model|| / ||C||.
template <typename Model>
double relative_error(const Eigen::MatrixXf& columns, const Model& model) {
  return (columns.cast<double>() - model.template cast<double>()).norm() / columns.cast<double>().norm();
}

inline double displayed_error(const OnlineSvd& factor, const Eigen::MatrixXf& columns) {
  return relative_error(columns, factor.displayed_basis() * factor.displayed_coefficients());
}

}  // namespace sheen
