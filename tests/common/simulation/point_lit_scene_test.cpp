// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/point_lit_scene.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace sheen {
namespace {

/// A square metre of ground at z = 0 and a small square 0.2 m above its middle, both facing up.
Mesh ground_and_roof() {
  Mesh mesh;
  for (const auto& [half, height] : {std::pair{0.5f, 0.0f}, std::pair{0.05f, 0.2f}}) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
      mesh.vertices.emplace_back(half * static_cast<float>(x), half * static_cast<float>(y), height);
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
  }
  return mesh;
}

/// From a metre above: a pixel is a centimetre of ground.
PosedCamera from_above() {
  PosedCamera posed;
  posed.camera = {.width = 81, .height = 81, .fx = 100, .fy = 100, .cx = 40, .cy = 40};
  posed.camera_from_object = {Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 1}};
  return posed;
}

class PointLitSceneTest : public testing::Test {
 protected:
  const Mesh mesh_ = ground_and_roof();
  const PointLitScene scene_{mesh_, vertex_normals(mesh_),
                             [](auto&&...) -> Eigen::Array3f {
                               return {0.5f, 0.25f, 1};
                             },
                             from_above()};
};

TEST_F(PointLitSceneTest, APointLightFallsOffAsTheCubeOfItsDistance) {
  const LightState light{.kind = LightKind::kPoint, .position = {0.1, -0.2, 0.8}, .rgb = {1, 2, 3}};
  const ImageF picture = scene_.picture(light);
  // Ground at x = 0.3, y = 0.25: the picture's y runs down.
  const Eigen::Vector3d place(0.3, 0.25, 0), way = light.position - place;
  const double expected = 0.8 / std::pow(way.norm(), 3);
  const float* pixel = picture.pixel(70, 15);
  EXPECT_NEAR(pixel[0], 0.5 * expected, 1e-4);
  EXPECT_NEAR(pixel[1], 0.25 * 2 * expected, 1e-4);
  EXPECT_NEAR(pixel[2], 3 * expected, 1e-4);
}

TEST_F(PointLitSceneTest, AFarLightIsTheSameEverywhere) {
  const LightState light{.kind = LightKind::kDirectional, .position = {0, 3, 4}};
  const ImageF picture = scene_.picture(light);
  for (const auto& [x, y] : {std::pair{5, 5}, {75, 5}, {40, 78}}) EXPECT_NEAR(picture.at(x, y, 2), 0.8, 1e-5);
}

TEST_F(PointLitSceneTest, TheRoofsShadowIsWhereItMustBe) {
  // From the side at 45 degrees: the roof's middle at height 0.2 shades the ground at x = 0.2.
  const LightState light{.kind = LightKind::kDirectional, .position = {-1, 0, 1}};
  const ImageU8 lit = scene_.lit(light);
  const ImageF picture = scene_.picture(light);
  EXPECT_EQ(lit.at(60, 40), 0);
  EXPECT_EQ(picture.at(60, 40, 0), 0);
  for (const int x : {53, 67, 20}) EXPECT_EQ(lit.at(x, 40), 255) << x;
  EXPECT_EQ(lit.at(40, 40), 255) << "the roof itself";
  EXPECT_EQ(scene_.lit({.kind = LightKind::kPoint, .position = {0, 0, -1}}).at(60, 40), 0) << "from below";
  EXPECT_THROW(scene_.picture({}), std::invalid_argument);
}

}  // namespace
}  // namespace sheen
