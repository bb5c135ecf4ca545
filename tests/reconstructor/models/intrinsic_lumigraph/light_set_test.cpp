// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/lumigraph_file/light_set.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/errors.h"
#include "reconstructor/radiance/light_refusal.h"

namespace sheen {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

LightSet half_circle(int count) {
  LightSet lights{.kind = LightKind::kPoint, .places = Eigen::Matrix3Xd(3, count)};
  for (int i = 0; i < count; ++i) {
    const double turn = M_PI * i / (count - 1);
    lights.places.col(i) = Vector3d(std::cos(turn), std::sin(turn), 1);
  }
  return lights;
}

TEST(LightSetTest, HalfwayTakesHalfOfEach) {
  const LightSet lights = half_circle(7);
  const double turn = M_PI * 2.5 / 6;
  const auto weights = lights.between({std::cos(turn), std::sin(turn), 1});
  float sum = 0;
  for (const auto& [light, weight] : weights) {
    sum += weight;
    if (light == 2 || light == 3) EXPECT_NEAR(weight, 0.5, 0.02);
  }
  EXPECT_NEAR(sum, 1, 1e-6);
}

TEST(LightSetTest, OnALightItIsThatOne) {
  const LightSet lights = half_circle(5);
  const auto weights = lights.between(lights.places.col(3));
  ASSERT_EQ(weights.size(), 1u);
  EXPECT_EQ(weights[0].first, 3);
  EXPECT_EQ(weights[0].second, 1);
}

TEST(LightSetTest, AGridIsInterpolatedInTwoDirections) {
  LightSet lights{.kind = LightKind::kPoint, .places = Eigen::Matrix3Xd(3, 4)};
  lights.places << 0, 1, 0, 1, 0, 0, 1, 1, 2, 2, 2, 2;
  Vector3d mean = Vector3d::Zero();
  const Vector3d place(0.3, 0.2, 2);
  for (const auto& [light, weight] : lights.between(place)) {
    EXPECT_GE(weight, 0);
    mean += weight * lights.places.col(light);
  }
  EXPECT_LT((mean - place).norm(), 0.02);
}

TEST(LightSetTest, OutsideTheNearestAreTaken) {
  const LightSet lights = half_circle(3);
  for (const auto& [light, weight] : lights.between({2, -0.5, 1})) EXPECT_TRUE(light == 0 || weight < 0.05);
}

TEST(LightSetTest, PointLightFallsWithTheSquareOfTheDistance) {
  const LightSet lights = half_circle(3);  // all sqrt(2) from the origin
  const Vector3f above(0, 0, 0);
  EXPECT_NEAR(lights.lamp(Vector3d(0, 0, std::sqrt(2.0))).incidence(above).norm(), 1, 1e-6);
  EXPECT_NEAR(lights.lamp(Vector3d(0, 0, 2 * std::sqrt(2.0))).incidence(above).norm(), 0.25, 1e-6);
  EXPECT_LT((lights.lamp(Vector3d(0, 3, 0)).incidence(above).normalized() - Vector3f::UnitY()).norm(), 1e-6);
}

TEST(LightSetTest, AnotherKindOfLightIsRefused) {
  const LightSet lights = half_circle(3);
  EXPECT_THROW(lights.place_of({.kind = LightKind::kDirectional, .position = {0, 0, 1}}), ConfigError);
  EXPECT_EQ(light_refusal({.kind = LightKind::kFixed}, LightKind::kPoint), "no_light_position");
  EXPECT_EQ(light_refusal({.kind = LightKind::kDirectional, .position = {0, 0, 0}}, LightKind::kDirectional),
            "broken_light");
}

}  // namespace
}  // namespace sheen
