// SPDX-License-Identifier: Apache-2.0
#include <Eigen/QR>
#include <optional>
#include <random>
#include <span>

#include "reconstructor/numerics/missing_pca.h"
#include "tests/bench/numerics_rows.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

constexpr int kOrders = 5;

using Known = std::span<const std::uint8_t>;

/// Least squares on the visible rows, as the paper has it (000 sec. 3.2).
Eigen::VectorXf least_squares(const Eigen::MatrixXf& basis, const Eigen::VectorXf& column, Known known) {
  std::vector<int> rows;
  for (int i = 0; i < static_cast<int>(known.size()); ++i)
    if (known[i]) rows.push_back(i);
  const Eigen::MatrixXd visible = basis(rows, Eigen::all).cast<double>();
  return visible.colPivHouseholderQr().solve(column(rows).cast<double>()).cast<float>();
}

double visible_fraction(Known known) {
  return static_cast<double>(std::count(known.begin(), known.end(), 1)) / static_cast<double>(known.size());
}

/// The paper's gates: an image is not used when less than half of the patch is visible, nor before the tenth one when
/// anything is hidden.
class GatedStream {
 public:
  explicit GatedStream(const OnlineSvdOptions& options, int rows) : factor_(rows, options) {}
  void add(Eigen::VectorXf column, Known known) {
    const double fraction = visible_fraction(known);
    if (fraction < 0.5 || (fraction < 1 && used_ < 10)) return;
    if (fraction < 1) {
      const Eigen::VectorXf fill = factor_.basis() * least_squares(factor_.basis(), column, known);
      for (Eigen::Index i = 0; i < column.size(); ++i)
        if (!known[i]) column[i] = fill[i];
    }
    factor_.add(column);
    ++used_;
  }
  int used() const { return used_; }
  const OnlineSvd& fold() {
    factor_.fold();
    return factor_;
  }

 private:
  OnlineSvd factor_;
  int used_ = 0;
};

/// Errors of a stream relative to those of the batch that saw everything.
struct StreamErrors {
  std::vector<double> known;  ///< model against what was visible
  std::vector<double> span;   ///< all columns, unoccluded, against the span of the basis
  std::vector<double> all;    ///< model against everything, what was never visible included
};

double span_error(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& basis) {
  return (columns - basis * (basis.transpose() * columns)).norm() / columns.norm();
}

void occluded_stream(TestPatch kind, const std::string& name, double occluded, double goal, double moonshot,
                     GoalReport& report) {
  const Eigen::MatrixXf columns = test_patch_columns(kind);
  const Eigen::MatrixXd exact = columns.cast<double>();
  const BatchPca best = batch_pca(columns, kDisplayed);
  const Eigen::MatrixXd best_miss = exact - best.basis * best.coefficients;
  const auto orders = column_orders(columns, kOrders);
  const OnlineSvdOptions options{.max_rank = kDisplayed, .tolerance = 0, .channels = 3};
  StreamErrors ours, equal_weights, gated;
  std::vector<double> gated_used, reported;
  double missing_batch = 0, missing_batch_span = 0;
  for (std::uint32_t trial = 0; trial < kOrders; ++trial) {
    const std::vector<int>& order = orders[3 + trial];
    const auto visible = occluding_edges(kTestPatchViews, occluded, trial);
    const Eigen::MatrixXd shown = visible.cast<double>().matrix();
    const double best_known = shown.cwiseProduct(best_miss).norm() / shown.cwiseProduct(exact).norm();
    const Eigen::MatrixXd exact_in_order = exact(Eigen::all, order), shown_in_order = shown(Eigen::all, order);

    const auto measure = [&](bool weighted, StreamErrors& errors) {
      OnlineSvd factor(static_cast<int>(columns.rows()), options);
      for (const int j : order) {
        const Known known(visible.col(j).data(), static_cast<std::size_t>(visible.rows()));
        const double fraction = visible_fraction(known);
        factor.add(columns.col(j), known, weighted ? fraction * fraction : 1);  // as `image_weight` does
      }
      factor.fold();
      const Eigen::MatrixXd basis = factor.displayed_basis().cast<double>();
      const Eigen::MatrixXd miss = exact_in_order - basis * factor.displayed_coefficients().cast<double>();
      const double seen = shown_in_order.cwiseProduct(miss).norm() / shown_in_order.cwiseProduct(exact_in_order).norm();
      errors.known.push_back(seen / best_known);
      errors.span.push_back(span_error(exact, basis) / best.relative_error);
      errors.all.push_back(miss.norm() / exact.norm() / best.relative_error);
      if (weighted) reported.push_back(factor.displayed_error() / seen);
    };
    measure(true, ours);
    measure(false, equal_weights);

    GatedStream paper(options, static_cast<int>(columns.rows()));
    for (const int j : order)
      paper.add(columns.col(j), Known(visible.col(j).data(), static_cast<std::size_t>(visible.rows())));
    gated_used.push_back(static_cast<double>(paper.used()) / kTestPatchViews);
    gated.span.push_back(span_error(exact, paper.fold().displayed_basis().cast<double>()) / best.relative_error);
    if (trial == 0) {
      const BatchPca visible_batch = batch_pca_missing(columns, visible, kDisplayed, {}, {.max_iterations = 60});
      missing_batch = visible_batch.relative_error / best_known;
      missing_batch_span = span_error(exact, visible_batch.basis) / best.relative_error;
    }
  }
  const auto median = [](const std::vector<double>& values) { return quantile(values, 0.5); };
  char title[96];
  std::snprintf(title, sizeof title, "%.0f %% of columns occluded, over full batch, %s", 100 * occluded, name.c_str());
  report.add(at_most(goal, moonshot, title, std::max(median(ours.known), median(ours.span)), "ratio",
                     {{"visible_values", median(ours.known)},
                      {"span", median(ours.span)},
                      {"span_worst_order", quantile(ours.span, 1)},
                      {"all_values", median(ours.all)},
                      {"equal_weights_span", median(equal_weights.span)},
                      {"gated_least_squares_span", median(gated.span)},
                      {"gated_fraction_of_images_used", median(gated_used)},
                      {"batch_of_visible_values", missing_batch},
                      {"batch_of_visible_values_span", missing_batch_span},
                      {"self_reported_over_true", median(reported)}}));
}

/// Columns that a factor of 200 others has to complete from a fiftieth of their rows.
void two_percent_visible(GoalReport& report) {
  nlohmann::json compared;
  std::vector<double> ours, theirs;
  for (const TestPatch kind : {TestPatch::kTypical, TestPatch::kHard}) {
    const Eigen::MatrixXf columns = test_patch_columns(kind);
    const std::vector<int> order = column_orders(columns, 1)[3];
    OnlineSvd factor(static_cast<int>(columns.rows()), {.max_rank = kDisplayed, .tolerance = 0, .channels = 3});
    for (int i = 0; i < 200; ++i) factor.add(columns.col(order[i]));
    factor.fold();
    std::mt19937 engine(3);
    std::bernoulli_distribution shown(0.02);
    std::vector<double> most_probable, gates_open;
    for (int i = 200; i < kTestPatchViews; ++i) {
      const Eigen::VectorXf column = columns.col(order[i]);
      std::vector<std::uint8_t> known(static_cast<std::size_t>(column.size()), 0);
      for (int s = 0; s < kTestPatchSamples; ++s)
        if (shown(engine)) std::fill_n(known.begin() + 3 * s, 3, std::uint8_t{1});
      const auto error = [&](const Eigen::VectorXf& y) { return (factor.basis() * y - column).norm() / column.norm(); };
      most_probable.push_back(error(factor.estimate(column, known, factor.row_noise())));
      gates_open.push_back(error(least_squares(factor.basis(), column, known)));
    }
    ours.insert(ours.end(), most_probable.begin(), most_probable.end());
    theirs.insert(theirs.end(), gates_open.begin(), gates_open.end());
    const std::string name = kind == TestPatch::kTypical ? "typ" : "hard";
    compared[name + "_median"] = quantile(most_probable, 0.5);
    compared[name + "_p95"] = quantile(most_probable, 0.95);
    compared[name + "_least_squares_median"] = quantile(gates_open, 0.5);
    compared[name + "_least_squares_p95"] = quantile(gates_open, 0.95);
  }
  compared["least_squares"] = quantile(theirs, 0.5);
  report.add({"completed from 2 % of its rows, median error", quantile(ours, 0.5), "", {}, true, compared});
}

}  // namespace

void measure_missing(GoalReport& report) {
  occluded_stream(TestPatch::kTypical, "typ", 0.5, 1.06, 1.04, report);
  occluded_stream(TestPatch::kHard, "hard", 0.5, 1.06, 1.04, report);
  occluded_stream(TestPatch::kTypical, "typ", 0.8, 1.12, 1.08, report);
  occluded_stream(TestPatch::kHard, "hard", 0.8, 1.12, 1.08, report);
  two_percent_visible(report);
}

}  // namespace sheen
