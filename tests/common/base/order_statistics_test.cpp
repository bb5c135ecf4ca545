// SPDX-License-Identifier: Apache-2.0
#include "common/base/order_statistics.h"

#include <gtest/gtest.h>

#include <span>
#include <vector>

namespace sheen {
namespace {

TEST(Median, IsTheValueInTheMiddleOrTheUpperOfTwo) {
  std::vector<float> values{5, 1, 4, 2, 3};
  EXPECT_EQ(median(values), 3);
  EXPECT_EQ(median(std::span(values).first(1)), values[0]);
  EXPECT_EQ(median(std::vector{4.0, 1.0, 3.0, 2.0}), 3.0);
}

TEST(Median, IsTheMeanOfBothMiddlesWhereThatIsAskedFor) {
  EXPECT_EQ(median_of_both_middles<double>(std::vector{7, 1, 4, 2}), 3.0);
  EXPECT_EQ(median_of_both_middles<double>(std::vector{7, 1, 4}), 4.0);
  EXPECT_EQ(median_of_both_middles<float>(std::vector{2.0f, 2.0f}), 2.0f);
}

TEST(Quantile, HasAFractionOfTheOthersBelowIt) {
  const std::vector<double> values{5, 1, 3, 2, 4};
  EXPECT_EQ(quantile(values, 0.0), 1);
  EXPECT_EQ(quantile(values, 0.5), 3);
  EXPECT_EQ(quantile(values, 0.74), 3);
  EXPECT_EQ(quantile(values, 0.75), 4);
  EXPECT_EQ(quantile(values, 1.0), 5);
}

}  // namespace
}  // namespace sheen
