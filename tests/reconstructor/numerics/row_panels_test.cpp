// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/row_panels.h"

#include <gtest/gtest.h>

#include <limits>

namespace sheen {
namespace {

/// All products alike: each addition is rounded the same way as the one before.
TEST(RowPanels, ProductsOfConstantColumnsAreExactToAFewUnits) {
  const Eigen::VectorXf third = Eigen::VectorXf::Constant(40'000, 1 / 3.0f);
  for (const float value : {0.1f, 0.7f, 0.013f}) {
    const Eigen::VectorXf column = Eigen::VectorXf::Constant(third.size(), value);
    for (const int rows : {48, 192, 1008, 4000, 40'000}) {
      const double truth = rows * (double{value} * double{third[0]});
      const double product =
          row_panels::inner_products(row_panels::columns(column, 1), row_panels::columns(third, 1), rows)(0, 0);
      EXPECT_NEAR(product / truth, 1, 3 * std::numeric_limits<float>::epsilon()) << rows << " of " << value;
    }
  }
}

}  // namespace
}  // namespace sheen
