// SPDX-License-Identifier: Apache-2.0
// Random hostile matrices: whatever comes, the invariants hold and the batch is not far.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;

// Columns of one block are told apart in single precision: what differs from the others by less than the root of some
// rounding units of its norm may be lost, or be counted as lost when it is not (docs/numerics.md).
constexpr double kBlockDigits = 1.5e-3;

/// Columns that are made of a few directions, repeated, zero, tiny, huge or noise.
MatrixXf hostile_matrix() {
  const int rows = *rc::gen::inRange(1, 60), columns = *rc::gen::inRange(1, 80), terms = *rc::gen::inRange(1, 12);
  const auto seed = *rc::gen::inRange<std::uint32_t>(0, 1U << 30);
  const float decay = *rc::gen::element(1.0f, 0.7f, 0.3f, 0.05f);
  const float noise = *rc::gen::element(0.0f, 1e-6f, 1e-3f, 0.1f);
  const float scale = *rc::gen::element(1e-30f, 1e-6f, 1.0f, 255.0f, 1e6f, 1e25f);
  MatrixXf spans = gaussian_matrix(rows, terms, seed);
  for (int t = 0; t < terms; ++t) spans.col(t) *= std::pow(decay, static_cast<float>(t));
  MatrixXf data = spans * gaussian_matrix(terms, columns, seed + 1) + noise * gaussian_matrix(rows, columns, seed + 2);
  for (int j = 0; j < columns; ++j) {
    const int kind = *rc::gen::inRange(0, 12);
    if (kind == 0) data.col(j).setZero();
    if (kind == 1 && j > 0) data.col(j) = data.col(j - 1);
    if (kind == 2 && j > 0) data.col(j) = -data.col(0);
    if (kind == 3) data.col(j) *= 1e-5f;
    if (kind == 4) data.col(j) *= 1e3f;
    if (kind == 5) data(*rc::gen::inRange(0, rows), j) = 1e4f;
  }
  return scale * data;
}

OnlineSvdOptions any_options() {
  const int max_rank = *rc::gen::inRange(1, 16);
  const double tolerance = *rc::gen::element(0.0, 1e-4, 0.01, 0.1);
  return {.max_rank = max_rank,
          .internal_rank = *rc::gen::element(0, max_rank, max_rank + 3),
          .block = *rc::gen::inRange(1, 20),
          .tolerance = tolerance};
}

RC_GTEST_PROP(OnlineSvdProperties, InvariantsHold, ()) {
  const MatrixXf data = hostile_matrix();
  const OnlineSvdOptions options = any_options();
  OnlineSvd factor(static_cast<int>(data.rows()), options, *rc::gen::inRange(0U, 40U));
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    factor.add(data.col(j));
    RC_ASSERT(broken_invariants(factor) == "");
  }
  RC_ASSERT(broken_invariants(factor.settled()) == "");
}

RC_GTEST_PROP(OnlineSvdProperties, TheErrorIsWhatItSays, ()) {
  const MatrixXf data = hostile_matrix();
  const OnlineSvdOptions options = any_options();
  const OnlineSvd factor = settled_factor(data, options);
  const Eigen::MatrixXd columns = data.cast<double>();
  RC_PRE(columns.norm() > 0);
  RC_ASSERT(std::abs(factor.energy() / columns.squaredNorm() - 1) < 1e-5);
  // Parts of a column that are lost at different times need not be orthogonal: on matrices as hostile as these the sum
  // is off by up to a quarter below and twice above; on patches it is exact to a few percent. That is no bound: of a
  // million such matrices 16 were beyond it. So one of those drawn here may be, and two hardly ever are. None of
  // 650,000 had an error 1.6 times as large as it said.
  const double error = model_error(factor, data);
  const bool as_it_says = error <= 1.25 * factor.relative_error() + kBlockDigits &&
                          displayed_model_error(factor, data) <= 1.25 * factor.displayed_error() + kBlockDigits &&
                          factor.relative_error() <= 2.5 * error + kBlockDigits;
  RC_ASSERT(error <= 1.6 * factor.relative_error() + kBlockDigits);
  RC_ASSERT(displayed_model_error(factor, data) <= 1.6 * factor.displayed_error() + kBlockDigits);
  static int beyond = 0;
  beyond += as_it_says ? 0 : 1;
  RC_ASSERT(beyond <= 1);
}

RC_GTEST_PROP(OnlineSvdProperties, WithinTheToleranceUnlessTheRankIsCapped, ()) {
  const MatrixXf data = hostile_matrix();
  OnlineSvdOptions options = any_options();
  options.max_rank = 80;  // no cap
  options.internal_rank = 0;
  const OnlineSvd factor = settled_factor(data, options);
  RC_PRE(data.cast<double>().norm() > 0);
  RC_ASSERT(displayed_model_error(factor, data) <= 1.05 * options.tolerance + kBlockDigits);
}

RC_GTEST_PROP(OnlineSvdProperties, IsNearlyTheBatch, ()) {
  const MatrixXf data = hostile_matrix();
  OnlineSvdOptions options = any_options();
  options.internal_rank = 0;  // as advised: twice the displayed
  options.tolerance = 0;
  const OnlineSvd factor = settled_factor(data, options);
  RC_PRE(data.cast<double>().norm() > 0);
  RC_ASSERT(displayed_model_error(factor, data) <=
            1.05 * batch_pca(data, options.max_rank).relative_error + kBlockDigits);
}

RC_GTEST_PROP(OnlineSvdProperties, FloatAndDoubleAgree, ()) {
  const MatrixXf data = hostile_matrix();
  OnlineSvdOptions options = any_options();
  options.tolerance = 0.01;  // ranks are decided well above the rounding of either
  const OnlineSvd single = settled_factor(data, options);
  OnlineSvdDouble precise(static_cast<int>(data.rows()), options);
  for (Eigen::Index j = 0; j < data.cols(); ++j) precise.add(data.col(j).cast<double>());
  precise.fold();
  RC_PRE(data.cast<double>().norm() > 0);
  RC_ASSERT(broken_invariants(precise) == "");
  RC_ASSERT(std::abs(displayed_model_error(single, data) - displayed_model_error(precise, data)) < 2e-3);
}

RC_GTEST_PROP(OnlineSvdProperties, MissingRowsRemovalAndMergingKeepTheInvariants, ()) {
  const MatrixXf data = hostile_matrix();
  const OnlineSvdOptions options = any_options();
  OnlineSvd factor(static_cast<int>(data.rows()), options, *rc::gen::inRange(0U, 40U));
  for (Eigen::Index j = 0; j < data.cols(); ++j) {
    const int fraction = *rc::gen::element(0, 1, 20, 60, 100);
    std::vector<std::uint8_t> known(static_cast<std::size_t>(data.rows()));
    for (std::uint8_t& k : known) k = *rc::gen::inRange(0, 100) < fraction;
    factor.add(data.col(j), known, *rc::gen::element(1e-3, 0.5, 1.0, 100.0));
    const int act = *rc::gen::inRange(0, 6);
    if (act == 0) factor.remove(*rc::gen::inRange(0, factor.views()));
    if (act == 1 && factor.folded_views() > 1) {
      const int kept = *rc::gen::inRange(1, factor.folded_views());
      factor.merge_views(kept, *rc::gen::inRange(0, kept));
    }
    if (act == 2) factor.fold();
    RC_ASSERT(broken_invariants(factor) == "");
  }
  RC_ASSERT(broken_invariants(factor.settled()) == "");
}

}  // namespace
}  // namespace sheen
