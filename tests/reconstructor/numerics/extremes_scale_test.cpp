// SPDX-License-Identifier: Apache-2.0
// Values of any size, and values that are none.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "reconstructor/numerics/batch_pca.h"
#include "reconstructor/numerics/online_svd.h"
#include "tests/support/online_svd_checks.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class Scale : public testing::TestWithParam<float> {};

TEST_P(Scale, IsCarriedThroughAndChangesNothingElse) {
  const MatrixXf data = patch_like_matrix(150, 60, 8, 0.01f, 1);
  const float scale = GetParam();
  const OnlineSvdOptions options{.max_rank = 6, .tolerance = 0.01};
  const OnlineSvd plain = settled_factor(data, options), scaled = settled_factor(scale * data, options);
  EXPECT_EQ(broken_invariants(scaled), "");
  EXPECT_EQ(scaled.rank(), plain.rank());
  EXPECT_EQ(scaled.displayed_rank(), plain.displayed_rank());
  EXPECT_NEAR(scaled.relative_error(), plain.relative_error(), 1e-5);
  EXPECT_NEAR(displayed_model_error(scaled, scale * data), displayed_model_error(plain, data), 1e-5);
  EXPECT_NEAR(scaled.energy() / (double(scale) * scale), plain.energy(), 1e-5 * plain.energy());
}

INSTANTIATE_TEST_SUITE_P(FromTinyToHuge, Scale, testing::Values(1e-30f, 1e-20f, 1e-8f, 255.0f, 1e8f, 1e20f, 1e30f));

TEST(Scales, DenormalsAreKeptAsFarAsTheyHaveDigits) {
  const MatrixXf data = 1e-40f * patch_like_matrix(150, 40, 3, 0, 2);  // 1e-45 is the least: about five digits left
  ASSERT_EQ(std::fpclassify(data(3, 3)), FP_SUBNORMAL);
  const OnlineSvd factor = settled_factor(data, {.max_rank = 6, .tolerance = 0});
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_LT(displayed_model_error(factor, data), 1e-4);
}

TEST(Scales, TheLeastNumberOfAllIsAColumnToo) {
  VectorXf column = VectorXf::Zero(20);
  column[4] = std::numeric_limits<float>::denorm_min();
  OnlineSvd factor(20, {.max_rank = 3});
  for (int i = 0; i < 5; ++i) factor.add(column);
  factor.fold();
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_EQ(factor.rank(), 1);
  EXPECT_GT(factor.energy(), 0);
}

TEST(Scales, AStreamThatGrowsByThirtyOrdersForgetsOnlyWhatIsBelowItsRounding) {
  // Each column a decade brighter than the last, each in a direction of its own.
  const MatrixXf directions = gaussian_matrix(90, 31, 3);
  MatrixXf data(90, 31);
  for (int j = 0; j < 31; ++j) data.col(j) = std::pow(10.0f, static_cast<float>(j - 15)) * directions.col(j);
  for (const bool fading : {false, true}) {
    const MatrixXf stream = fading ? MatrixXf(data.rowwise().reverse()) : data;
    const OnlineSvd factor = settled_factor(stream, {.max_rank = 8, .tolerance = 0});
    EXPECT_EQ(broken_invariants(factor), "") << fading;
    EXPECT_LT(displayed_model_error(factor, stream), 1e-6) << fading;
  }
}

TEST(Scales, AHighlightTenThousandTimesThePatchIsKept) {
  MatrixXf data = patch_like_matrix(300, 80, 0, 0.005f, 4);
  data.col(37).segment(40, 6).setConstant(1e4f);
  for (const double tolerance : {0.0, 1e-3}) {
    const OnlineSvd factor = settled_factor(data, {.max_rank = 8, .tolerance = tolerance});
    EXPECT_EQ(broken_invariants(factor), "");
    const VectorXf spot = factor.displayed_basis() * factor.displayed_coefficients().col(37);
    EXPECT_NEAR(spot[42], 1e4f, 1);
    // The patch without it is not lit by it.
    const VectorXf other = factor.displayed_basis() * factor.displayed_coefficients().col(36);
    if (tolerance == 0) EXPECT_LT((other - data.col(36)).norm(), 0.02 * data.col(36).norm());
  }
}

TEST(Scales, NanAndInfinityAreMaskedWhereTheyEnter) {
  const MatrixXf clean = patch_like_matrix(120, 60, 3, 0.01f, 5);
  MatrixXf damaged = clean;
  for (int j = 20; j < 60; j += 4) {
    damaged(3 * (j % 40), j) = kNan;
    damaged(3 * (j % 37) + 1, j) = kInfinity;
    damaged(3 * (j % 31) + 2, j) = -kInfinity;
  }
  OnlineSvd factor(120, {.max_rank = 8, .tolerance = 0}), masked(120, {.max_rank = 8, .tolerance = 0});
  for (int j = 0; j < 60; ++j) {
    factor.add(damaged.col(j));
    std::vector<std::uint8_t> known(120, 1);
    for (int i = 0; i < 120; ++i) known[i] = std::isfinite(damaged(i, j));
    masked.add(clean.col(j), known);
  }
  factor.fold();
  masked.fold();
  EXPECT_EQ(broken_invariants(factor), "");
  EXPECT_EQ(MatrixXf(factor.basis()), MatrixXf(masked.basis())) << "not finite and not known are the same";
  EXPECT_EQ(factor.coefficients(), masked.coefficients());
  EXPECT_LT(displayed_model_error(factor, clean), 1.1 * batch_pca(clean, 8).relative_error);
}

TEST(Scales, AColumnOfNothingButNanIsAViewOfWhichNothingIsKnown) {
  const MatrixXf data = patch_like_matrix(90, 30, 3, 0.01f, 6);
  for (const int at : {0, 1, 13, 29}) {
    MatrixXf damaged = data;
    damaged.col(at).setConstant(kNan);
    const OnlineSvd factor = settled_factor(damaged, {.max_rank = 8, .tolerance = 0});
    EXPECT_EQ(broken_invariants(factor), "") << at;
    EXPECT_EQ(factor.views(), 30) << at;
    damaged.col(at) = data.col(at);
    EXPECT_LT(factor.coefficients().col(at).norm(), 2 * data.col(at).norm()) << at;
  }
}

TEST(Scales, HugeAndTinyWeightsCountAsTheyShould) {
  const MatrixXf data = patch_like_matrix(90, 30, 4, 0.01f, 7);
  for (const double weight : {1e-12, 1e12}) {
    OnlineSvd factor(90, {.max_rank = 6, .tolerance = 0});
    for (int j = 0; j < 30; ++j) factor.add(data.col(j), weight);
    factor.fold();
    EXPECT_EQ(broken_invariants(factor), "");
    EXPECT_NEAR(factor.energy() / weight, data.cast<double>().squaredNorm(), 1e-5 * factor.energy() / weight);
    EXPECT_LT(displayed_model_error(factor, data), 1.01 * batch_pca(data, 6).relative_error);
  }
}

}  // namespace
}  // namespace sheen
