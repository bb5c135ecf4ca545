// SPDX-License-Identifier: Apache-2.0
#include "common/base/running_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace sheen {
namespace {

TEST(RunningStatistics, QuantilesAgreeWithSortingToOnePercent) {
  std::mt19937 random(7);
  std::lognormal_distribution<double> durations(std::log(0.02), 1.5);
  RunningStatistics statistics;
  std::vector<double> all;
  double sum = 0;
  for (int i = 0; i < 5000; ++i) {
    all.push_back(durations(random));
    sum += all.back();
    statistics.add(all.back());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(statistics.count(), all.size());
  EXPECT_NEAR(statistics.sum_s(), sum, 1e-9 * sum);
  EXPECT_EQ(statistics.min_s(), all.front());
  EXPECT_EQ(statistics.max_s(), all.back());
  for (const double q : {0.01, 0.25, 0.5, 0.9, 0.95, 0.99, 0.999}) {
    const double truth = all[static_cast<std::size_t>(std::ceil(q * 5000)) - 1];
    EXPECT_NEAR(statistics.quantile_s(q), truth, 0.0101 * truth) << q;
  }
}

TEST(RunningStatistics, OneValueIsEveryQuantile) {
  for (const double value : {0.0, 3e-7, 1e-6, 0.0371, 12.5, 1e6}) {
    RunningStatistics statistics;
    statistics.add(value);
    for (const double q : {0.0, 0.5, 1.0}) EXPECT_DOUBLE_EQ(statistics.quantile_s(q), value);
  }
}

TEST(RunningStatistics, EmptyIsNotANumber) {
  const RunningStatistics statistics;
  EXPECT_TRUE(std::isnan(statistics.median_s()));
  EXPECT_TRUE(std::isnan(statistics.min_s()));
  EXPECT_TRUE(std::isnan(statistics.max_s()));
}

TEST(RunningStatistics, HostileDurations) {
  RunningStatistics statistics;
  statistics.add(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(statistics.count(), 0U);
  statistics.add(-1.0);
  statistics.add(std::numeric_limits<double>::infinity());
  EXPECT_EQ(statistics.count(), 2U);
  EXPECT_EQ(statistics.quantile_s(0.5), 0.0);
  EXPECT_TRUE(std::isfinite(statistics.quantile_s(1.0)));
}

}  // namespace
}  // namespace sheen
