// SPDX-License-Identifier: Apache-2.0
// What the factorization is measured on and compared with: the two test patches, the occluder, Brand's plain update.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "reconstructor/numerics/batch_pca.h"
#include "tests/support/matchers.h"
#include "tests/support/plain_brand.h"
#include "tests/support/test_matrices.h"
#include "tests/support/test_patches.h"

namespace sheen {
namespace {

TEST(TestPatches, AreAsHardAsTheGoalsAreStatedFor) {
  EXPECT_NEAR(batch_pca(test_patch_columns(TestPatch::kTypical), 12).relative_error, 0.0397, 0.0005);
  EXPECT_NEAR(batch_pca(test_patch_columns(TestPatch::kHard), 12).relative_error, 0.253, 0.002);
}

TEST(TestPatches, OrdersAreSortedOrShuffledPermutations) {
  const Eigen::MatrixXf columns = patch_like_matrix(20, 50, 3, 0.1f, 1);
  const auto orders = column_orders(columns, 4);
  ASSERT_EQ(orders.size(), 7U);
  for (const std::vector<int>& order : orders) EXPECT_EQ(std::set(order.begin(), order.end()).size(), 50U);
  const auto norm = [&](int j) { return columns.col(j).norm(); };
  EXPECT_TRUE(std::is_sorted(orders[1].begin(), orders[1].end(), [&](int a, int b) { return norm(a) < norm(b); }));
  EXPECT_TRUE(std::is_sorted(orders[2].begin(), orders[2].end(), [&](int a, int b) { return norm(a) > norm(b); }));
  EXPECT_EQ(std::set(orders.begin(), orders.end()).size(), 7U) << "no order twice";
}

TEST(TestPatches, AnOccluderHidesWholeSamplesOnOneSide) {
  const auto visible = occluding_edges(200, 0.5, 3);
  const Eigen::Matrix2Xf samples = test_patch_samples();
  int occluded = 0;
  for (int v = 0; v < 200; ++v) {
    const double hidden = 1 - visible.col(v).cast<double>().mean();
    if (hidden == 0) continue;
    ++occluded;
    EXPECT_GT(hidden, 0.17);
    EXPECT_LT(hidden, 0.81);
    // The means of both sides are apart in one direction, and that direction separates them.
    Eigen::Vector2f shown_mean(0, 0), hidden_mean(0, 0);
    int shown = 0;
    for (int s = 0; s < kTestPatchSamples; ++s) {
      ASSERT_EQ(visible(3 * s, v), visible(3 * s + 2, v));
      (visible(3 * s, v) ? shown_mean : hidden_mean) += samples.col(s);
      shown += visible(3 * s, v);
    }
    EXPECT_GT((shown_mean / shown - hidden_mean / (kTestPatchSamples - shown)).norm(), 0.5f);
  }
  EXPECT_NEAR(occluded, 100, 25);
}

TEST(PlainBrand, IsTheSvdAsLongAsNothingIsDropped) {
  // With enough noise: of a column whose new part is small, the plain update loses orthogonality by eps ||c|| / ||p||.
  const Eigen::MatrixXf data = patch_like_matrix(60, 20, 6, 0.05f, 4);
  PlainBrand brand(60, {.cap = 30});
  for (int j = 0; j < 20; ++j) brand.add(data.col(j).cast<double>());
  const BatchPca pca = batch_pca(data, 5);
  EXPECT_TRUE(brand.singular_values().isApprox(pca.singular_values, 1e-9));
  EXPECT_TRUE(brand.model(5).isApprox(pca.basis * pca.coefficients, 1e-8));
  EXPECT_LT(orthogonality_loss(brand.u()), 1e-10);
}

TEST(PlainBrand, AtTheCapDropsTheLeastTermOrFreezes) {
  // Two small columns, then a large one in a new direction.
  const Eigen::MatrixXd columns = Eigen::Vector3d(1, 2, 10).asDiagonal();
  PlainBrand truncating(3, {.cap = 2}), frozen(3, {.cap = 2, .freezes = true});
  for (int j = 0; j < 3; ++j) {
    truncating.add(columns.col(j));
    frozen.add(columns.col(j));
  }
  EXPECT_NEAR((truncating.model(2) - columns).norm(), 1, 1e-12);
  EXPECT_NEAR((frozen.model(2) - columns).norm(), 10, 1e-12);
}

}  // namespace
}  // namespace sheen
