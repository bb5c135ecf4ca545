// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <map>

#include "reconstructor/numerics/batch_pca.h"
#include "tests/bench/numerics_rows.h"
#include "tests/support/plain_brand.h"
#include "tests/support/test_rings.h"

namespace sheen {
namespace {

struct Range {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

double brand_error(const Eigen::MatrixXf& columns, const PlainBrandOptions& options) {
  PlainBrand brand(static_cast<int>(columns.rows()), options);
  for (Eigen::Index j = 0; j < columns.cols(); ++j) brand.add(columns.col(j).cast<double>());
  return relative_error(columns, brand.model(kDisplayed));
}

struct Ring {
  std::string name;
  Eigen::MatrixXf columns;
  std::vector<std::vector<int>> orders;
  BatchPca best;
  double goal, moonshot;  ///< of the error over the batch's
  Range reported;         ///< self-reported over true error

  Eigen::MatrixXf in_order(std::size_t i) const { return columns(Eigen::all, orders[i]); }
};

Ring make_ring(TestRing kind, std::string name, double goal, double moonshot) {
  const Eigen::MatrixXf columns = test_ring_columns(kind);
  return {std::move(name), columns, column_orders(columns), batch_pca(columns, kDisplayed), goal, moonshot, {}};
}

void error_over_batch(Ring& ring, GoalReport& report) {
  Range twice, once, in_double;
  for (std::size_t i = 0; i < ring.orders.size(); ++i) {
    const Eigen::MatrixXf columns = ring.in_order(i);
    const OnlineSvd factor = factor_of(columns, {.max_rank = kDisplayed, .tolerance = 0});
    twice.add(displayed_error(factor, columns) / ring.best.relative_error);
    ring.reported.add(factor.displayed_error() / displayed_error(factor, columns));
    ring.reported.add(factor.relative_error() / relative_error(columns, factor.basis() * factor.coefficients()));

    const OnlineSvd plain = factor_of(columns, {.max_rank = kDisplayed, .internal_rank = kDisplayed, .tolerance = 0});
    once.add(displayed_error(plain, columns) / ring.best.relative_error);

    OnlineSvdDouble precise(static_cast<int>(columns.rows()), {.max_rank = kDisplayed, .tolerance = 0});
    for (Eigen::Index j = 0; j < columns.cols(); ++j) precise.add(columns.col(j).cast<double>());
    precise.fold();
    in_double.add(relative_error(columns, precise.displayed_basis() * precise.displayed_coefficients()) /
                  ring.best.relative_error);
  }
  // Brand's own worst order is among the sorted ones; its tolerances are absolute, as in published codes.
  Range capped, frozen, tolerant;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::MatrixXf columns = ring.in_order(i);
    capped.add(brand_error(columns, {.cap = kDisplayed}) / ring.best.relative_error);
    frozen.add(brand_error(columns, {.cap = kDisplayed, .freezes = true}) / ring.best.relative_error);
    if (i < 2) tolerant.add(brand_error(columns, {.cap = 60, .tolerance = 2}) / ring.best.relative_error);
  }
  report.add(at_most(ring.goal, ring.moonshot, "rank-12 error over batch, worst of 23 orders, " + ring.name, twice.most,
                     "ratio",
                     {{"batch_error", ring.best.relative_error},
                      {"internal_12", once.most},
                      {"double_precision", in_double.most},
                      {"brand_cap_12_of_4_orders", capped.most},
                      {"brand_cap_12_frozen_of_4_orders", frozen.most},
                      {"brand_tolerance_2_of_2_orders", tolerant.most}}));
}

/// Rank that the tolerance asks for, against the smallest that meets it in a batch.
void adaptive_rank(const std::vector<Ring>& rings, GoalReport& report) {
  int most_above = std::numeric_limits<int>::min();
  double most_error = 0;
  nlohmann::json compared;
  for (const Ring& ring : rings) {
    const Eigen::VectorXd& s = ring.best.singular_values;
    for (const double tolerance : {0.4, 0.3, 0.2, 0.1, 0.05, 0.03, 0.02}) {
      int batch_rank = 0;
      while (s.tail(s.size() - batch_rank).norm() > tolerance * s.norm()) ++batch_rank;
      if (batch_rank > 20) break;  // what a ring may show
      int worst = 0;
      for (std::size_t i = 0; i < ring.orders.size(); ++i) {
        const Eigen::MatrixXf columns = ring.in_order(i);
        const OnlineSvd factor = factor_of(columns, {.max_rank = 24, .internal_rank = 32, .tolerance = tolerance});
        worst = std::max(worst, factor.displayed_rank());
        most_error = std::max(most_error, displayed_error(factor, columns) / tolerance);
      }
      most_above = std::max(most_above, worst - batch_rank);
      char name[48];
      std::snprintf(name, sizeof name, "%s_%g", ring.name.c_str(), tolerance);
      compared[name] = std::to_string(worst) + " of " + std::to_string(batch_rank);
    }
  }
  compared["error_over_tolerance"] = most_error;
  report.add(at_most(1, 0, "adaptive rank above the batch's, worst of 23 orders", most_above, "terms", compared));
}

/// What half precision of basis and coefficients costs.
void half_precision(const Ring& ring, GoalReport& report) {
  nlohmann::json compared;
  double worst = 0;
  for (const int rank : {12, 24}) {
    const OnlineSvd factor = factor_of(ring.columns, {.max_rank = rank, .tolerance = 0});
    const auto basis = factor.displayed_basis().eval(), y = factor.displayed_coefficients().eval();
    const auto rounded = [](const Eigen::MatrixXf& m) { return m.cast<Eigen::half>().cast<float>().eval(); };
    const double full = relative_error(ring.columns, basis * y);
    const double loss = 20 * std::log10(relative_error(ring.columns, rounded(basis) * y) / full);
    worst = std::max(worst, loss);
    compared["rank_" + std::to_string(rank) + "_coefficients_too_dB"] =
        20 * std::log10(relative_error(ring.columns, rounded(basis) * rounded(y)) / full);
    // What storage adds, if the factorization itself were perfect.
    compared["rank_" + std::to_string(rank) + "_rounding_alone"] =
        relative_error(basis * y, rounded(basis) * rounded(y));
  }
  report.add({.name = "half-precision basis, accuracy lost, " + ring.name,
              .value = worst,
              .unit = "dB",
              .compared_with = compared});
}

}  // namespace

void measure_accuracy(GoalReport& report) {
  std::vector<Ring> rings{make_ring(TestRing::kTypical, "typ", 1.001, 1.0003),
                          make_ring(TestRing::kHard, "hard", 1.01, 1.003)};
  for (Ring& ring : rings) error_over_batch(ring, report);
  adaptive_rank(rings, report);
  Range reported;
  for (const Ring& ring : rings) {
    reported.add(ring.reported.least);
    reported.add(ring.reported.most);
  }
  GoalRow row = at_most(1.10, 1.03, "self-reported over true error, most of 23 orders", reported.most, "ratio",
                        {{"least", reported.least}});
  row.holds = row.holds && reported.least > 0.999;
  report.add(row);
  for (const Ring& ring : rings) half_precision(ring, report);
}

}  // namespace sheen
