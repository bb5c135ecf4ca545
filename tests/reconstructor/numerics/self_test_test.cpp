// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/self_test.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sheen {
namespace {

TEST(NumericsSelfTest, TheShippedFactorHoldsAtTheExtremes) {
  const std::vector<NumericsCheck> checks = numerics_self_test();
  EXPECT_GE(checks.size(), 10u);
  for (const NumericsCheck& check : checks) {
    std::printf("%-75s %.3g of %.3g\n", check.name.c_str(), check.value, check.bound);
    EXPECT_TRUE(check.holds()) << check.name << ": " << check.value << ", at most " << check.bound;
  }
}

TEST(NumericsSelfTest, WhatIsNoNumberDoesNotHold) {
  EXPECT_FALSE((NumericsCheck{"", std::numeric_limits<double>::quiet_NaN(), 1}.holds()));
  EXPECT_TRUE((NumericsCheck{"", 1, 1}.holds()));
}

}  // namespace
}  // namespace sheen
