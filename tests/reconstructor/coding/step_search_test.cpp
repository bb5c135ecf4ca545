// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/step_search.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace sheen {
namespace {

struct Best {
  double found = 0;  ///< the largest that is not beyond what is wanted; 0 where all are
  int tries = 0;
};

Best search(double wanted, double slope, const std::function<double(double step)>& quantity) {
  StepSearch search(wanted, slope, 8, 0.1, 100);
  Best best;
  for (bool more = true; more;) {
    EXPECT_GE(search.step(), 0.0999);
    EXPECT_LE(search.step(), 100.1);
    const double found = quantity(search.step());
    if (found <= wanted) best.found = std::max(best.found, found);
    ++best.tries;
    more = search.next(found);
  }
  return best;
}

/// Losses as compressing measures them: they rise in uneven stairs, where a step changes nothing or much at once.
TEST(StepSearch, ComesCloseToWhatRisesInStairs) {
  constexpr int kSearches = 500;
  constexpr double kStair = 0.03;  // in the step's logarithm: of a loss by 4 to 8 %
  double worst = 1, tries = 0;
  for (unsigned i = 0; i < kSearches; ++i) {
    std::mt19937 random(i);
    std::uniform_real_distribution<double> uniform(0, 1);
    const double at_8 = std::pow(10, -2.2 + 2 * uniform(random)), power = 1.2 + 1.3 * uniform(random);
    const Best best = search(0.1, 1.2, [&](double step) {
      const double stair = std::floor(std::log(step / 8) / kStair);
      std::mt19937 of_stair(i + static_cast<unsigned>(7919 * (stair + 1000)));
      return at_8 * std::exp(power * kStair * stair) * (1 + 0.01 * (2 * uniform(of_stair) - 1));
    });
    worst = std::min(worst, best.found / 0.1);
    tries += best.tries;
  }
  EXPECT_GT(worst, 0.9);
  EXPECT_LT(tries / kSearches, 6);
}

TEST(StepSearch, ReachesBytesWhichFallAsTheStepGrows) {
  for (const double power : {-0.6, -0.9, -1.4})
    for (const double at_8 : {2e5, 1e6, 4e6})
      EXPECT_GT(search(1e6, -0.9, [&](double step) { return at_8 * std::pow(step / 8, power); }).found, 0.98e6)
          << power;
}

TEST(StepSearch, EndsWhereNoStepReachesWhatIsWanted) {
  EXPECT_EQ(search(1e-3, 1.2, [](double) { return 1.0; }).found, 0);
  EXPECT_NEAR(search(1e9, -0.9, [](double step) { return 1 / step; }).found, 10, 1e-6);
}

}  // namespace
}  // namespace sheen
