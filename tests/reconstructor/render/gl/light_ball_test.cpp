// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/light_ball.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

TEST(LightBall, TheLightIsWhereItIsPointedAt) {
  EXPECT_TRUE(light_at({0, 0}).isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(light_at({0.6, 0}).isApprox(Eigen::Vector3d(0.6, 0, 0.8)));
  const Eigen::Vector3d rim = light_at({-3, 4});
  EXPECT_NEAR(rim.norm(), 1, 1e-12);
  EXPECT_GT(rim.z(), 0) << "never behind the picture";
  EXPECT_LT(rim.z(), 0.1);
  EXPECT_NEAR(rim.y() / rim.x(), -4.0 / 3, 1e-12);
}

TEST(LightBall, TurnsAndComesBack) {
  const Eigen::Vector3d light(0.3, 0.4, std::sqrt(0.75));
  EXPECT_TRUE(turned_light(light, 0, 0).isApprox(light));
  EXPECT_TRUE(turned_light(turned_light(light, 0.2, -0.3), -0.2, 0.3).isApprox(light));
  EXPECT_GT(turned_light(light, 0.2, 0).x(), light.x()) << "to the right";
  EXPECT_GT(turned_light(light, 0, 0.2).y(), light.y()) << "and up";
  for (const double right : {-9.0, 0.0, 9.0})
    for (const double up : {-9.0, 0.0, 9.0}) {
      const Eigen::Vector3d turned = turned_light(light, right, up);
      EXPECT_NEAR(turned.norm(), 1, 1e-12);
      EXPECT_GT(turned.z(), 0) << right << " " << up;
    }
}

TEST(LightBall, ThePicturesAxesAreRightUpAndTowardsTheEye) {
  const Eigen::Matrix3d axes = picture_axes(look_at({2, 0, 0}, {0, 0, 0}, {0, 0, 1}));
  EXPECT_TRUE((axes * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE((axes * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(0, 1, 0)));
  EXPECT_TRUE((axes * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(1, 0, 0)));
}

TEST(LightBall, IsSaidInWords) {
  EXPECT_EQ(light_in_words({0, 0, 1}), "Light from the front");
  EXPECT_EQ(light_in_words(Eigen::Vector3d(-1, 1, std::sqrt(2)).normalized()),
            "Light from the upper left, 45 degrees off the picture");
  EXPECT_EQ(light_in_words({1, 0, 0}), "Light from the right, 0 degrees off the picture");
  EXPECT_EQ(light_in_words({0, -0.8, 0.6}), "Light from below, 37 degrees off the picture");
}

}  // namespace
}  // namespace sheen
