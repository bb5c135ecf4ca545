// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/fixed_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace sheen {
namespace {

TEST(FixedPoint, IsWrongByHalfOfAStepAtMostWhateverTheSizeOfTheNumbers) {
  for (const float scale : {1e-30f, 1.0f, 1e30f}) {
    std::vector<float> values;
    for (int i = -100; i <= 100; ++i) values.push_back(scale * std::sin(0.37f * static_cast<float>(i)));
    const FixedPoint stored(values);
    ASSERT_EQ(stored.size(), values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(stored.at<float>(i) / scale, values[i] / scale, 0.51 / 32767) << scale << " " << i;
  }
}

TEST(FixedPoint, TheLargestOfEitherSignAndZeroAreExact) {
  const std::vector<float> values = {0.75f, 0, -0.75f};
  const FixedPoint stored(values);
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_FLOAT_EQ(stored.at<float>(i), values[i]);
}

TEST(FixedPoint, NothingButZerosAndTheLeastNumberOfAllAreNoTrouble) {
  const FixedPoint zeros(std::vector<double>{0, 0});
  EXPECT_EQ(zeros.at<double>(1), 0);
  const double least = std::numeric_limits<double>::denorm_min();
  EXPECT_LE(FixedPoint(std::vector<double>{least}).at<double>(0), least);
  EXPECT_EQ(FixedPoint().size(), 0u);
}

}  // namespace
}  // namespace sheen
