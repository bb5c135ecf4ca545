// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/shared_rows.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "reconstructor/numerics/ring_factor.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;
using Mask = std::vector<std::uint8_t>;
using Runs = std::vector<SharedRows<float>>;

constexpr int kRows = 150, kHalf = 90;

/// Rows 0..89 and 90..149 of a column; those that `known` leaves out are 0.
Runs two_runs(const VectorXf& column, const Mask& known) {
  VectorXf shown = column;
  for (int row = 0; row < kRows; ++row)
    if (!known.empty() && !known[row]) shown[row] = 0;
  return {shared_rows(VectorXf(shown.head(kHalf))), shared_rows(VectorXf(shown.tail(kRows - kHalf)))};
}

/// Every third column hides a part; that of every ninth is all of the second run.
Mask mask_of(int j) {
  if (j % 3 != 0) return {};
  Mask known(kRows, 1);
  for (int row = j % 9 == 0 ? kHalf : 40; row < (j % 9 == 0 ? kRows : 110); ++row) known[row] = 0;
  return known;
}

void expect_same_bits(const RingFactor& a, const RingFactor& b) {
  const RingFactor x = a.settled(), y = b.settled();
  EXPECT_EQ(MatrixXf(x.basis()), MatrixXf(y.basis()));
  EXPECT_EQ(x.coefficients(), y.coefficients());
  EXPECT_EQ(x.lost_energy(), y.lost_energy());
}

TEST(SharedRows, AFactorMakesOfRunsWhatItMakesOfWholeColumns) {
  const MatrixXf data = ring_like_matrix(kRows, 60, 6, 0.01f, 3);
  RingFactor whole(kRows, {.max_rank = 6}), of_runs(kRows, {.max_rank = 6});
  for (int j = 0; j < data.cols(); ++j) {
    const Mask known = mask_of(j);
    Runs runs = two_runs(data.col(j), known);
    if (j % 9 == 0) runs[1].values.reset();  // nothing of it is shown
    whole.add(data.col(j), known, 0.5 + j % 2);
    of_runs.add(std::move(runs), known, 0.5 + j % 2);
    if (j % 7 == 0) expect_same_bits(whole, of_runs);
  }
  for (const int view : {57, 40, 3}) {  // one that waits, and two that are folded
    whole.remove(view);
    of_runs.remove(view);
    expect_same_bits(whole, of_runs);
  }
}

TEST(SharedRows, ValuesThatAreNotFiniteCountAsUnknownAndScalesAreKept) {
  const MatrixXf data = ring_like_matrix(kRows, 20, 4, 0.01f, 5);
  RingFactor whole(kRows, {.max_rank = 4}), of_runs(kRows, {.max_rank = 4});
  for (int j = 0; j < data.cols(); ++j) {
    VectorXf column = 1e20f * data.col(j);
    if (j == 11) column[100] = std::numeric_limits<float>::infinity();
    if (j == 12) column[7] = std::numeric_limits<float>::quiet_NaN();
    whole.add(column);
    of_runs.add(two_runs(column, {}), {}, 1);
  }
  EXPECT_TRUE(MatrixXf(of_runs.basis()).allFinite());
  expect_same_bits(whole, of_runs);
}

TEST(SharedRows, WhatThreeFactorsHoldCountsOnce) {
  const MatrixXf data = ring_like_matrix(kRows, 9, 4, 0.01f, 7);
  std::vector<RingFactor> factors(3, RingFactor(kRows, {}));
  for (int j = 0; j < 8; ++j)  // which are folded one by one
    for (RingFactor& factor : factors) factor.add(data.col(j));
  const std::size_t before = factors[0].bytes();
  const Runs runs = two_runs(data.col(8), {});
  factors[0].add(runs, {}, 1);
  const std::size_t alone = factors[0].bytes() - before;
  factors[1].add(runs, {}, 1);
  factors[2].add(runs, {}, 1);
  // The runs that this test holds are the fourth part.
  EXPECT_LT(factors[0].bytes() - before, alone);
  EXPECT_LT(3 * (factors[0].bytes() - before), 3 * sizeof(float) * kRows + 3 * 250);
  EXPECT_EQ(runs[0].values.use_count(), 4);
  for (RingFactor& factor : factors) factor.fold();
  EXPECT_EQ(runs[0].values.use_count(), 1) << "nobody holds them any more";
}

TEST(SharedRows, RunsThatAreNoColumnAreRefused) {
  RingFactor factor(kRows, {});
  EXPECT_THROW(factor.add(Runs{shared_rows(VectorXf::Ones(kRows - 1).eval())}, {}, 1), std::invalid_argument);
  EXPECT_THROW(factor.add(two_runs(VectorXf::Ones(kRows), {}), Mask(3, 1), 1), std::invalid_argument);
  EXPECT_EQ(factor.views(), 0);
}

}  // namespace
}  // namespace sheen
