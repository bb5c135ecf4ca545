// SPDX-License-Identifier: Apache-2.0
#include "common/base/median.h"

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

}  // namespace
}  // namespace sheen
