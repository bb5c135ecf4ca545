// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/light_spacing.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

namespace sheen {
namespace {

constexpr double kTolerance = 16.0 / 255;

/// A surface element: where it is below the plane z = 0 of the light, and how it stands.
struct Element {
  Eigen::Vector3d place, normal, lobe;
};

/// Exposure of the element with a light at a place of the plane; in that of the brightest element at distance 1.
double exposure(const Element& element, double exponent, double q, double r) {
  const Eigen::Vector3d to_light = Eigen::Vector3d(q, r, 0) - element.place;
  const double d2 = to_light.squaredNorm();
  const Eigen::Vector3d light = to_light / std::sqrt(d2);
  return std::pow(std::max(0.0, light.dot(element.lobe)), exponent) * std::max(0.0, light.dot(element.normal)) / d2;
}

class Elements {
 public:
  Element next() {
    const auto direction = [&] {
      return Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_)).normalized();
    };
    Element element;
    // Most near the worst: under the light at the least distance, facing it.
    const double spread = std::pow(10, -3 * uniform_(random_));
    element.place = {2 * spread * (uniform_(random_) - 0.5), 2 * spread * (uniform_(random_) - 0.5),
                     -1 - spread * uniform_(random_)};
    element.normal = (Eigen::Vector3d::UnitZ() + 3 * spread * direction()).normalized();
    element.lobe = (Eigen::Vector3d::UnitZ() + 3 * spread * direction()).normalized();
    return element;
  }
  double share() { return uniform_(random_); }

 private:
  std::mt19937_64 random_{7};
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> uniform_;
};

struct Worst {
  double lit = 0;       ///< error of elements that all four lights reach
  double anywhere = 0;  ///< of all, those at the horizon included
};

/// Largest errors of bilinear interpolation in a cell of this size round the origin.
Worst worst_error(double exponent, double spacing, int trials) {
  Elements elements;
  Worst worst;
  for (int i = 0; i < trials; ++i) {
    const Element element = elements.next();
    const double a = elements.share(), b = elements.share(), h = spacing / 2;
    double sum = 0;
    bool lit = true;
    for (const double q : {-h, h})
      for (const double r : {-h, h}) {
        const double value = exposure(element, exponent, q, r);
        lit = lit && (Eigen::Vector3d(q, r, 0) - element.place).dot(element.normal) > 0 &&
              (exponent == 0 || (Eigen::Vector3d(q, r, 0) - element.place).dot(element.lobe) > 0);
        sum += (q > 0 ? a : 1 - a) * (r > 0 ? b : 1 - b) * value;
      }
    const double error = std::abs(sum - exposure(element, exponent, h * (2 * a - 1), h * (2 * b - 1)));
    worst.anywhere = std::max(worst.anywhere, error);
    if (lit) worst.lit = std::max(worst.lit, error);
  }
  return worst;
}

TEST(LightSpacingTest, NoLitElementIsOffByMoreThanTheTolerance) {
  for (const double exponent : {0.0, 1.0, 5.0, 50.0}) {
    const ReflectanceLobe lobe{.weight = 0.7, .exponent = exponent};
    const LightSpacing spacing = plan_spacing({&lobe, 1}, 1, kTolerance);
    EXPECT_LE(worst_error(exponent, spacing.on_grid, 400000).lit, kTolerance) << exponent;
    EXPECT_GT(worst_error(exponent, 2 * spacing.on_grid, 400000).lit, kTolerance) << "a wider one breaks it";
  }
}

/// The bound is within 2 % of what elements reach: for a tolerance so small that only second derivatives count.
TEST(LightSpacingTest, TheBoundIsTight) {
  constexpr double kSmall = 1e-4;
  for (const double exponent : {0.0, 1.0, 20.0}) {
    const ReflectanceLobe lobe{.exponent = exponent};
    const Element worst{{0, 0, -1}, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ()};
    const LightSpacing spacing = plan_spacing({&lobe, 1}, 1, kSmall);
    const double h = spacing.on_grid / 2, l = spacing.along_line / 2;
    EXPECT_NEAR(exposure(worst, exponent, 0, 0) - exposure(worst, exponent, h, h), kSmall, 0.02 * kSmall);
    EXPECT_NEAR(exposure(worst, exponent, 0, 0) - exposure(worst, exponent, l, 0), kSmall, 0.02 * kSmall);
  }
}

/// At the horizon the plain spacing is not enough, and the wider margin is.
TEST(LightSpacingTest, TheHorizonNeedsLess) {
  const ReflectanceLobe matt;
  const LightSpacing spacing = plan_spacing({&matt, 1}, 1, kTolerance);
  EXPECT_LT(spacing.on_grid_with_horizon, spacing.on_grid);
  EXPECT_LE(worst_error(0, spacing.on_grid_with_horizon, 400000).anywhere, kTolerance);
  const Element horizon{{0, 0, -1}, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  const double fine = 1e-3;
  const double h = plan_spacing({&matt, 1}, 1, fine).on_grid / 2;
  EXPECT_GT(exposure(horizon, 0, h, 0) / 2, 5 * fine) << "the kink alone breaks a small tolerance";
  const double safe = plan_spacing({&matt, 1}, 1, fine).on_grid_with_horizon / 2;
  EXPECT_LE(exposure(horizon, 0, safe, 0) / 2, fine);
}

TEST(LightSpacingTest, ScalesWithTheDistanceAndMixesLobes) {
  const ReflectanceLobe lobes[] = {{.weight = 1, .exponent = 0}, {.weight = 3, .exponent = 8}};
  const LightSpacing one = plan_spacing(lobes, 1, kTolerance), two = plan_spacing(lobes, 2, kTolerance);
  EXPECT_DOUBLE_EQ(two.on_grid, 2 * one.on_grid);
  EXPECT_DOUBLE_EQ(one.on_grid, std::sqrt(4 * kTolerance / ((3 + 3 * 11) / 4.0)));
  EXPECT_DOUBLE_EQ(one.along_line, std::sqrt(2) * one.on_grid);
}

}  // namespace
}  // namespace sheen
