// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/numerics/light_search.h"

#include <gtest/gtest.h>

#include "reconstructor/numerics/light_spacing.h"
#include "tests/support/light_elements.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 16.0 / 255, kPi = std::numbers::pi;
constexpr std::int64_t kElements = 500'000;  // `deploy/measure relighting` tries ten million

/// A search over normals finds what is known in closed form.
TEST(LightSearchTest, FindsTheClosedForm) {
  for (const double exponent : {0.0, 1.0, 2.0, 3.0, 8.0, 50.0, 1330.0, 1e5}) {
    const ExposureBounds found = search_bounds(FreeLobes({{.weight = 0.5, .exponent = exponent}}));
    EXPECT_NEAR(found.brightest, 0.5, 1e-6) << exponent;
    for (const auto& [value, truth] :
         {std::pair{found.point_curvature, 0.5 * (exponent + 3)}, {found.direction_curvature, 0.5 * (exponent + 1)}}) {
      EXPECT_GE(value, truth) << exponent;
      EXPECT_LE(value, 1.02 * truth) << exponent;
    }
    EXPECT_NEAR(found.horizon_slope, 0.5, 0.01) << exponent;
  }
}

TEST(LightSearchTest, MixedLobesAddUp) {
  const std::vector<ReflectanceLobe> lobes{{.weight = 1, .exponent = 0}, {.weight = 3, .exponent = 8}};
  const ExposureBounds found = search_bounds(FreeLobes(lobes)), known = lobe_bounds(lobes);
  EXPECT_NEAR(found.point_curvature, known.point_curvature, 0.02 * known.point_curvature);
  EXPECT_NEAR(found.direction_curvature, known.direction_curvature, 0.02 * known.direction_curvature);
}

/// The largest second derivative along a line through a light at height 1 over the element, or nearer: by a random
/// search with differences of the exposure's plain formula.
double climbed_curvature(const PlainReflectance& surface, double step) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto noise = [&]() -> Vector3d { return {normal(random), normal(random), normal(random)}; };
  struct State {
    Vector3d light, eye, line;
  };
  const auto curvature = [&](const State& s) {
    if (s.light.z() < 2 * step || s.eye.z() < std::cos(surface.steepest_eye)) return 0.0;
    const double rise = s.light.dot(s.line);  // the plane through the line that is squarest to the light
    const Vector3d place = s.light / std::sqrt(1 - rise * rise);
    const auto at = [&](double d) { return plain_exposure(surface, place + d * s.line, s.eye, false); };
    return std::abs(at(step) + at(-step) - 2 * at(0)) / (step * step);
  };
  double best = 0;
  for (int start = 0; start < 40; ++start) {
    State state{{0, 0, 1}, {0, 0, 1}, {1, 0, 0}};
    double value = 0;
    for (int i = 0; i < 4000; ++i) {
      const double size = i < 1000 ? 1 : std::pow(10, -3.0 * (i - 1000) / 3000);
      const State next{(state.light + size * noise()).normalized(), (state.eye + size * noise()).normalized(),
                       (state.line + size * noise()).normalized()};
      if (const double at = curvature(next); at > value) {
        state = next;
        value = at;
      }
    }
    best = std::max(best, value);
  }
  return best;
}

/// Microfacets have no closed form: what a random climb with plain formulas reaches, and no more than 2 % above.
TEST(LightSearchTest, IsWithinTwoPercentOfTheSupremum) {
  for (const double roughness : {0.3, 0.6}) {
    const AnalyticReflectance gloss({{.weight = 0.4}}, {{.normal_reflectance = 0.05, .roughness = roughness}});
    const double found = search_bounds(gloss).point_curvature;
    const double climbed = climbed_curvature(plain_microfacets(0.4, 0.05, roughness), 2e-4);
    EXPECT_GE(found, climbed) << roughness;
    EXPECT_LE(found, 1.02 * climbed) << roughness;
  }
}

TEST(LightSearchTest, ItsSpacingHoldsForRandomElements) {
  const PlainReflectance plain = plain_microfacets(0.4, 0.05, 0.3);
  const AnalyticReflectance gloss({{.weight = 0.4}}, {{.normal_reflectance = 0.05, .roughness = 0.3}});
  const ExposureBounds bounds = search_bounds(gloss);
  for (const bool far : {false, true}) {
    const LightSpacing spacing = far ? plan_direction_spacing(bounds, kTolerance) : plan_spacing(bounds, 1, kTolerance);
    const auto worst = LitElements(plain, spacing.on_grid, far, 3).worst(kElements);
    EXPECT_LE(worst.brightest, 1.001 * bounds.brightest);
    EXPECT_LE(worst.lit, kTolerance * bounds.brightest) << far;
    EXPECT_GT(LitElements(plain, 2 * spacing.on_grid, far, 3).worst(kElements).lit, kTolerance * bounds.brightest)
        << far;
  }
}

/// Lafortune's lobe with unequal coefficients: the eye that is best lit and its w are known.
TEST(LightSearchTest, AnisotropicLobes) {
  // w = (-x, -y, z) of the eye is a unit vector: as a free lobe. With c.x = 0 it is one only for eyes along y.
  for (const double cx : {-1.0, 0.0}) {
    const AnalyticReflectance lobe({{.c = {cx, -1, 1}, .exponent = 20}}, {});
    const ExposureBounds found = search_bounds(lobe);
    EXPECT_EQ(lobe.isotropic(), cx == -1);
    EXPECT_NEAR(found.brightest, 1, 1e-4);
    EXPECT_GE(found.point_curvature, 23);
    EXPECT_LE(found.point_curvature, 1.02 * 23);
  }
}

std::vector<double> angles(int count, double last) {
  std::vector<double> axis;
  for (int i = 0; i < count; ++i) axis.push_back(last * i / (count - 1));
  return axis;
}

/// A table of a matt surface under a lobe round the normal, (N.L)^8: by its angles of light and eye.
TEST(LightSearchTest, ReadsATableByLightAndEye) {
  const std::array axes{angles(91, kPi / 2), angles(10, kPi / 2), angles(10, kPi)};
  std::vector<float> values;
  for (const double light : axes[0])
    for (std::size_t i = 0; i < axes[1].size() * axes[2].size(); ++i)
      values.push_back(static_cast<float>(0.25 + 0.75 * std::pow(std::cos(light), 8)));
  const TabulatedReflectance table(TabulatedReflectance::Coordinates::kLightEye, axes, values, kPi / 180);
  const ExposureBounds found = search_bounds(table);
  const double truth = 0.25 * 3 + 0.75 * 11;
  EXPECT_NEAR(found.brightest, 1, 1e-3);
  EXPECT_NEAR(found.point_curvature, truth, 0.02 * truth);
}

/// A table by half vector and difference holds Blinn's lobe (N.H)^n exactly where the half vector is; light and eye may
/// change places.
TEST(LightSearchTest, ReadsATableByHalfVector) {
  constexpr double kExponent = 30;
  const std::array axes{angles(181, kPi / 2), angles(91, kPi / 2), angles(37, kPi)};
  std::vector<float> values;
  for (const double half : axes[0])
    for (const double difference : axes[1])
      for (const double azimuth : axes[2])
        values.push_back(static_cast<float>(std::pow(std::cos(half), kExponent) *
                                            (1 + 0.2 * std::cos(difference) + 0.1 * std::cos(2 * azimuth))));
  const TabulatedReflectance table(TabulatedReflectance::Coordinates::kHalfDifference, axes, values, kPi / 180);
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    Vector3d light(normal(random), normal(random), std::abs(normal(random))),
        eye(normal(random), normal(random), std::abs(normal(random)));
    light.normalize();
    eye.normalize();
    const Vector3d half = (light + eye).normalized();
    // Azimuth of the light about the half vector, from the plane of half vector and normal.
    const Vector3d away = (half.z() * half - Vector3d::UnitZ()).normalized(),
                   across = (light - light.dot(half) * half).normalized();
    const double cosine = away.dot(across),
                 truth = std::pow(half.z(), kExponent) * (1 + 0.2 * light.dot(half) + 0.1 * (2 * cosine * cosine - 1));
    EXPECT_NEAR(table.value(light, eye), truth, 4e-3);
    EXPECT_NEAR(table.value(eye, light), table.value(light, eye), 1e-9);
  }
}

TEST(LightSearchTest, WhatIsNoReflectanceIsRefused) {
  for (const double exponent : {-1.0, 0.5, 1.5, 2e5}) EXPECT_THROW(FreeLobes({{1, exponent}}), std::invalid_argument);
  EXPECT_THROW(FreeLobes({{0, 1}}), std::invalid_argument);
  EXPECT_THROW(AnalyticReflectance({}, {}), std::invalid_argument);
  EXPECT_THROW(AnalyticReflectance({}, {{.roughness = 0}}), std::invalid_argument);
  const std::array axes{angles(3, kPi / 2), angles(3, kPi / 2), angles(3, kPi)};
  using Table = TabulatedReflectance;
  EXPECT_THROW(Table(Table::Coordinates::kLightEye, axes, std::vector<float>(26, 1), 0.1), std::invalid_argument);
  EXPECT_THROW(Table(Table::Coordinates::kLightEye, axes, std::vector<float>(27, 0), 0.1), std::invalid_argument);
  auto falling = axes;
  std::swap(falling[1][0], falling[1][1]);
  EXPECT_THROW(Table(Table::Coordinates::kLightEye, falling, std::vector<float>(27, 1), 0.1), std::invalid_argument);
}

}  // namespace
}  // namespace sheen
