// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/map_resolution.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

/// Side of the map of a right triangle with legs of so many pixels, seen from 1 m.
int side_of(double pixels, const MapResolutionOptions& options = {}) {
  const auto leg = static_cast<float>(pixels * 1e-3 / std::sqrt(2.0));
  const Mesh mesh{{{-leg / 2, -leg / 2, 0}, {leg / 2, -leg / 2, 0}, {-leg / 2, leg / 2, 0}}, {{0, 1, 2}}};
  const Camera camera{.width = 640, .height = 480, .fx = 1000, .fy = 1000, .cx = 319.5, .cy = 239.5};
  return map_resolution(mesh, camera, look_at({0, 0, 1}, {0, 0, 0}, {0, 1, 0}), options).at(0);
}

TEST(MapResolution, HasASampleForEachPixelOfTheLongestEdge) {
  EXPECT_EQ(side_of(10), 11);
  EXPECT_EQ(side_of(22.8), 24);
  EXPECT_EQ(side_of(10, {.scale = 0.5}), 6);
}

TEST(MapResolution, KeepsToItsBounds) {
  EXPECT_EQ(side_of(0.1), 4);
  EXPECT_EQ(side_of(30), 24);
  EXPECT_EQ(side_of(46), 24);
  EXPECT_EQ(side_of(30, {.largest = 40}), 31);
}

TEST(MapResolution, OfALargeTriangleHasASampleForTwoPixels) {
  EXPECT_EQ(side_of(60), 31);
  EXPECT_EQ(side_of(300), 151);
  EXPECT_EQ(side_of(1e4), 255) << "what a byte holds";
}

TEST(MapResolution, AFixedOneIsTheSameForAllAndFitsItsByte) {
  EXPECT_EQ(side_of(300, {.fixed = 16}), 16);
  EXPECT_EQ(side_of(300, {.fixed = 16, .scale = 0.5}), 8);
  EXPECT_EQ(side_of(300, {.fixed = 2, .scale = 0.1}), 2);
  EXPECT_EQ(side_of(300, {.fixed = 64, .scale = 4}), 255);
}

}  // namespace
}  // namespace sheen
