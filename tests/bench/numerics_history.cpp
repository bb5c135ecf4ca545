// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "reconstructor/numerics/batch_pca.h"
#include "tests/bench/numerics_rows.h"
#include "tests/support/matchers.h"
#include "tests/support/plain_brand.h"
#include "tests/support/test_matrices.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

/// 257 columns that differ from one by 1e-4 of its norm.
Eigen::MatrixXf near_duplicates() {
  const Eigen::VectorXf column = test_patch_columns(TestPatch::kTypical).col(0);
  const float level = 1e-4f * column.norm() / std::sqrt(static_cast<float>(column.size()));
  return column.replicate(1, 257) + level * gaussian_matrix(static_cast<int>(column.size()), 257, 2);
}

void million_columns(GoalReport& report) {
  constexpr int kColumns = 1000000;
  const Eigen::MatrixXf pool = near_duplicates();
  OnlineSvd factor(static_cast<int>(pool.rows()), {.max_rank = kDisplayed, .tolerance = 0});
  double loss = 0;
  std::vector<double> times(pool.cols(), 0);
  for (int i = 0; i < kColumns; ++i) {
    factor.add(pool.col(i % pool.cols()));
    times[i % pool.cols()] += 1;
    while (factor.folded_views() > 64) factor.merge_views(0, 1);
    if (i % 20000 < factor.options().block && factor.pending() == 0)
      loss = std::max(loss, orthogonality_loss(factor.basis()));
  }
  factor.fold();
  loss = std::max(loss, orthogonality_loss(factor.basis()));

  const BatchPca exact = batch_pca(pool, 1, times);
  const double first = std::sqrt(factor.spectrum()[0]) / exact.singular_values[0];
  constexpr int kBrandColumns = 4000;
  PlainBrand brand(static_cast<int>(pool.rows()), {.cap = kDisplayed});
  for (int i = 0; i < kBrandColumns; ++i) brand.add(pool.col(i % pool.cols()).cast<double>());
  report.add(at_most(1e-6, 3e-7, "orthogonality lost in 10^6 near-duplicates", loss, "",
                     {{"brand_cap_12_double_after_4000", orthogonality_loss(brand.u())},
                      {"singular_value_off_by", std::abs(first - 1)}}));
}

/// How much the displayed coefficients of a view change with a column, relative to their norm; views and columns all
/// counted once ranks are full.
template <typename Coefficients>
void add_changes(const Coefficients& before, const Coefficients& after, std::vector<double>& changes) {
  const Eigen::Index rank = std::min(before.rows(), after.rows());
  for (Eigen::Index j = 0; j < before.cols(); ++j)
    changes.push_back(static_cast<double>((after.col(j).head(rank) - before.col(j).head(rank)).norm()) /
                      static_cast<double>(before.col(j).norm()));
}

void continuity(GoalReport& report) {
  std::vector<double> ours, ours_early, raw;
  for (const TestPatch patch : {TestPatch::kTypical, TestPatch::kHard}) {
    const Eigen::MatrixXf columns = test_patch_columns(patch);
    const auto orders = column_orders(columns, 1);
    for (const std::size_t order : {std::size_t(0), std::size_t(3)}) {
      OnlineSvd factor(static_cast<int>(columns.rows()), {.max_rank = kDisplayed, .tolerance = 0});
      PlainBrand brand(static_cast<int>(columns.rows()), {.cap = kDisplayed});
      Eigen::MatrixXf before(kDisplayed, 0);
      Eigen::MatrixXd brand_before(kDisplayed, 0);
      for (int j = 0; j < columns.cols(); ++j) {
        factor.add(columns.col(orders[order][j]));
        const Eigen::MatrixXf now = factor.settled().displayed_coefficients();
        if (j >= 2 * kDisplayed) add_changes(before, now, j < 60 ? ours_early : ours);
        before = now;
        if (j >= 100) continue;
        brand.add(columns.col(orders[order][j]).cast<double>());
        const Eigen::MatrixXd brand_now = brand.singular_values().asDiagonal() * brand.v().transpose();
        if (j >= 2 * kDisplayed) add_changes(brand_before, brand_now, raw);
        brand_before = brand_now;
      }
    }
  }
  std::vector<double> all = ours;
  all.insert(all.end(), ours_early.begin(), ours_early.end());
  report.add(at_most(2, 0.5, "change of old displayed coefficients per column, p95", 100 * quantile(all, 0.95), "%",
                     {{"median", 100 * quantile(all, 0.5)},
                      {"p95_of_columns_24_to_60", 100 * quantile(ours_early, 0.95)},
                      {"p95_behind_column_60", 100 * quantile(ours, 0.95)},
                      {"brand_cap_12_median", 100 * quantile(raw, 0.5)},
                      {"brand_cap_12_p95", 100 * quantile(raw, 0.95)}}));
}

Eigen::MatrixXf without(const Eigen::MatrixXf& columns, Eigen::Index removed) {
  Eigen::MatrixXf rest(columns.rows(), columns.cols() - 1);
  rest << columns.leftCols(removed), columns.rightCols(columns.cols() - removed - 1);
  return rest;
}

void removal(GoalReport& report) {
  double worst = 0, stranger = 0, to_batch = 0;
  for (const TestPatch patch : {TestPatch::kTypical, TestPatch::kHard}) {
    const Eigen::MatrixXf columns = test_patch_columns(patch);
    for (const int removed : {0, 20, 150, 290, 299}) {
      for (const bool strange : {false, true}) {
        Eigen::MatrixXf stream = columns;
        // Something else in the picture: nothing of it is in the span of the others.
        if (strange) stream.col(removed) = columns.col(removed).norm() / 49.5f * gaussian_matrix(2448, 1, 5);
        const OnlineSvdOptions options{.max_rank = kDisplayed, .tolerance = 0};
        OnlineSvd factor = factor_of(stream, options);
        factor.remove(removed);
        const Eigen::MatrixXf rest = without(stream, removed);
        const double never = displayed_error(factor_of(rest, options), rest);
        const double ratio = displayed_error(factor, rest) / never;
        (strange ? stranger : worst) = std::max(strange ? stranger : worst, ratio);
        to_batch = std::max(to_batch, displayed_error(factor, rest) / batch_pca(rest, kDisplayed).relative_error);
      }
    }
  }
  report.add(at_most(1.005, 1.001, "late removal over never inserted, worst", std::max(worst, stranger), "ratio",
                     {{"image_like_the_others", worst}, {"alien_image", stranger}, {"over_batch", to_batch}}));
}

void bytes(GoalReport& report) {
  const Eigen::MatrixXf columns = test_patch_columns(TestPatch::kHard);
  OnlineSvd factor(static_cast<int>(columns.rows()), {.max_rank = kDisplayed, .tolerance = 0});
  double most = 0;
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    factor.add(columns.col(j));
    most = std::max(most, static_cast<double>(factor.bytes()) / 1e3);
  }
  const double rows = static_cast<double>(columns.rows()), views = static_cast<double>(columns.cols());
  report.add(at_most(
      400, 250, "state per patch, internal 24, after 300 views", most, "kB",
      {{"brand_cap_24_kB", 8 * 24 * (rows + views) / 1e3}, {"batch_keeps_columns_kB", 4 * rows * views / 1e3}}));
}

}  // namespace

void measure_history(GoalReport& report) {
  removal(report);
  continuity(report);
  bytes(report);
  million_columns(report);
}

}  // namespace sheen
