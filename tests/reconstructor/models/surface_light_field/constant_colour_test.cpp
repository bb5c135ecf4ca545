// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/constant_colour.h"

#include <gtest/gtest.h>

#include <random>

#include "common/image/color.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

/// A square of two triangles, each with six samples, in one patch.
class ConstantColourTest : public testing::Test {
 protected:
  /// Grey levels of both triangles; a negative one: it is not shown.
  PatchColumn column(float first, float second) const {
    PatchColumn column{Eigen::VectorXf::Constant(36, NAN), std::vector<std::uint8_t>(12, 0)};
    for (int s = 0; s < 12; ++s) {
      const float level = s < 6 ? first : second;
      if (level < 0) continue;
      column.values.segment<3>(3 * s).setConstant(level);
      column.visible[static_cast<std::size_t>(s)] = 1;
    }
    return column;
  }
  float level(std::uint32_t triangle) const {
    const auto snapshot = appearance_of(std::make_shared<const ConstantColour>(colour_));
    return srgb_encode(snapshot->shader_for({{0, 0, 1}})->shade(triangle, 0.3f, 0.3f).rgb[1]);
  }

  std::shared_ptr<const Mesh> mesh_ = std::make_shared<Mesh>(square_mesh(0.1f, 0, 1));
  std::shared_ptr<const MapLayout> maps_ = std::make_shared<MapLayout>(std::vector<std::uint8_t>{3, 3});
  const std::vector<std::uint32_t> triangles_{0, 1}, vertices_{0, 1, 2, 3};
  const PatchShape patch_{.triangles = triangles_, .vertices = vertices_, .samples = 12};
  ConstantColour colour_{mesh_, maps_};
};

TEST_F(ConstantColourTest, RoundingStaysFarBelowAGreyLevel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> grey(0.1f, 0.9f);
  double sum = 0;
  constexpr int kImages = 3000;
  for (int i = 0; i < kImages; ++i) {
    const float seen = grey(random);
    sum += seen;
    colour_.add(patch_, column(seen, i % 3 == 0 ? 0.25f : -1.0f));
  }
  EXPECT_NEAR(level(0), sum / kImages, 0.05 / 255);
  EXPECT_NEAR(level(1), 0.25, 0.01 / 255);
}

TEST_F(ConstantColourTest, WhatIsTakenOutLeavesTheOthers) {
  const std::vector<float> seen = {0.2f, 0.7f, 0.4f, 0.9f};
  for (const float grey : seen) colour_.add(patch_, column(grey, grey));
  colour_.remove(patch_, column(seen[3], -1));
  colour_.remove(patch_, column(seen[1], -1));
  EXPECT_NEAR(level(0), (seen[0] + seen[2]) / 2, 1e-4);
  EXPECT_NEAR(level(1), 0.55, 1e-4);
  for (const float grey : {seen[0], seen[2]}) colour_.remove(patch_, column(grey, -1));
  EXPECT_NEAR(level(0), 0.55, 1e-4) << "nothing is left: a guess by the other triangle";
}

TEST_F(ConstantColourTest, WhatIsFarBrighterThanWhiteIsHeldToo) {
  colour_.add(patch_, column(0.5f, 0.5f));
  colour_.add(patch_, column(40.0f, 0.25f));
  EXPECT_NEAR(level(0), 20.25, 2e-3);
  EXPECT_NEAR(level(1), 0.375, 1e-4) << "a triangle that is not bright is as exact as before";
  colour_.remove(patch_, column(40.0f, -1));
  EXPECT_NEAR(level(0), 0.5, 2e-3);
}

}  // namespace
}  // namespace sheen
