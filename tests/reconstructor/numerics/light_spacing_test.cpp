// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/light_spacing.h"

#include <gtest/gtest.h>

#include "tests/support/light_elements.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 16.0 / 255;
constexpr std::int64_t kElements = 1'000'000;  // `deploy/measure relighting` tries ten million

ExposureBounds bounds_of(double exponent) {
  const ReflectanceLobe lobe{.weight = 0.7, .exponent = exponent};
  return lobe_bounds({&lobe, 1});
}

LitElements::Worst worst_error(double exponent, double spacing, bool far = false) {
  return LitElements(plain_lobe(exponent), spacing, far, 7).worst(kElements / 4);
}

TEST(LightSpacingTest, NoLitElementIsOffByMoreThanTheTolerance) {
  for (const double exponent : {0.0, 1.0, 5.0, 50.0}) {
    const double spacing = plan_spacing(bounds_of(exponent), 1, kTolerance).on_grid;
    EXPECT_LE(worst_error(exponent, spacing).lit, kTolerance) << exponent;
    EXPECT_GT(worst_error(exponent, 2 * spacing).lit, 1.5 * kTolerance) << "a wider one breaks it";
  }
}

TEST(LightSpacingTest, NorUnderFarLights) {
  for (const double exponent : {0.0, 1.0, 5.0, 50.0}) {
    const double spacing = plan_direction_spacing(bounds_of(exponent), kTolerance).on_grid;
    EXPECT_LE(worst_error(exponent, spacing, true).lit, kTolerance) << exponent;
    EXPECT_GT(worst_error(exponent, 2 * spacing, true).lit, 1.5 * kTolerance) << "a wider one breaks it";
  }
}

/// The bound is within 2 % of what elements reach: for a tolerance so small that only second derivatives count.
TEST(LightSpacingTest, TheBoundIsTight) {
  constexpr double kSmall = 1e-4;
  for (const double exponent : {0.0, 1.0, 20.0}) {
    const PlainReflectance surface = plain_lobe(exponent);
    const auto exposure = [&](double q, double r) {
      return plain_exposure(surface, {q, r, 1}, Vector3d::UnitZ(), false);
    };
    const LightSpacing spacing = plan_spacing(bounds_of(exponent), 1, kSmall);
    const double h = spacing.on_grid / 2, l = spacing.along_line / 2;
    EXPECT_NEAR(exposure(0, 0) - exposure(h, h), kSmall, 0.02 * kSmall);
    EXPECT_NEAR(exposure(0, 0) - exposure(l, 0), kSmall, 0.02 * kSmall);
  }
}

/// At the horizon the plain spacing is not enough, and the wider margin is.
TEST(LightSpacingTest, TheHorizonNeedsLess) {
  const LightSpacing spacing = plan_spacing(bounds_of(0), 1, kTolerance);
  EXPECT_LT(spacing.on_grid_with_horizon, spacing.on_grid);
  for (const double exponent : {0.0, 1.0, 5.0}) {
    const ExposureBounds bounds = bounds_of(exponent);
    EXPECT_LE(worst_error(exponent, plan_spacing(bounds, 1, kTolerance).on_grid_with_horizon).anywhere, kTolerance);
    EXPECT_LE(worst_error(exponent, plan_direction_spacing(bounds, kTolerance).on_grid_with_horizon, true).anywhere,
              kTolerance);
  }
  // An upright element whose horizon the light crosses.
  const auto exposure = [](double q) { return q > 0 ? q / std::pow(1 + q * q, 1.5) : 0; };
  const double fine = 1e-3, h = plan_spacing(bounds_of(0), 1, fine).on_grid / 2;
  EXPECT_GT(exposure(h) / 2, 5 * fine) << "the kink alone breaks a small tolerance";
  const double safe = plan_spacing(bounds_of(0), 1, fine).on_grid_with_horizon / 2;
  EXPECT_LE(exposure(safe) / 2, fine);
}

TEST(LightSpacingTest, ScalesWithTheDistanceAndMixesLobes) {
  const ReflectanceLobe lobes[] = {{.weight = 1, .exponent = 0}, {.weight = 3, .exponent = 8}};
  const ExposureBounds bounds = lobe_bounds(lobes);
  const LightSpacing one = plan_spacing(bounds, 1, kTolerance), two = plan_spacing(bounds, 2, kTolerance);
  EXPECT_DOUBLE_EQ(two.on_grid, 2 * one.on_grid);
  EXPECT_DOUBLE_EQ(one.on_grid, std::sqrt(4 * kTolerance / ((3 + 3 * 11) / 4.0)));
  EXPECT_DOUBLE_EQ(one.along_line, std::sqrt(2) * one.on_grid);
}

}  // namespace
}  // namespace sheen
