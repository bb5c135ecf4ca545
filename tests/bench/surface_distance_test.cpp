// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/surface_distance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

using Eigen::Vector3d;

/// The triangle (0, 0, 0), (3, 0, 0), (0, 4, 0): each region's distance is a closed form.
double to_right_angle(const Vector3d& point) {
  return distance_to_triangle(point, {0, 0, 0}, {3, 0, 0}, {0, 4, 0});
}

TEST(DistanceToTriangle, IsThatToItsFaceItsEdgesAndItsCorners) {
  EXPECT_DOUBLE_EQ(to_right_angle({1, 1, 2}), 2);
  EXPECT_DOUBLE_EQ(to_right_angle({1, 1, -2}), 2);
  EXPECT_DOUBLE_EQ(to_right_angle({1, 1, 0}), 0);
  EXPECT_DOUBLE_EQ(to_right_angle({1, -3, 4}), 5) << "the edge along x";
  EXPECT_DOUBLE_EQ(to_right_angle({-5, 2, 12}), 13) << "the edge along y";
  // The slanted edge lies on 4 x + 3 y = 12.
  EXPECT_NEAR(to_right_angle({1.5 + 4, 2 + 3, 0}), 5, 1e-12);
  EXPECT_DOUBLE_EQ(to_right_angle({-3, -4, 12}), 13) << "the corner at zero";
  EXPECT_DOUBLE_EQ(to_right_angle({3 + 8, -1, 4}), 9) << "the corner on x";
  EXPECT_DOUBLE_EQ(to_right_angle({-1, 4 + 8, 4}), 9) << "the corner on y";
}

TEST(DistanceToTriangle, OfOneWithoutArea) {
  EXPECT_DOUBLE_EQ(distance_to_triangle({1, 3, 4}, {0, 0, 0}, {2, 0, 0}, {1, 0, 0}), 5);
  EXPECT_DOUBLE_EQ(distance_to_triangle({3, 4, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}), 5);
}

TEST(SurfaceDistance, IsTheLeastOfAllTriangles) {
  Mesh mesh = sphere_mesh(0.1, 3);
  mesh.origin = {1000, -2000, 3};
  const SurfaceDistance distance(mesh);
  std::mt19937 chance(1);
  std::uniform_real_distribution<double> place(-0.2, 0.2);
  for (int i = 0; i < 200; ++i) {
    const Vector3d point(place(chance), place(chance), place(chance));
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      least = std::min(least, distance_to_triangle(point, mesh.corner(t, 0).cast<double>(),
                                                   mesh.corner(t, 1).cast<double>(), mesh.corner(t, 2).cast<double>()));
    EXPECT_NEAR(distance.to(point + mesh.origin), least, 1e-9);
    EXPECT_NEAR(least, std::abs(point.norm() - 0.1), 2e-3) << "the mesh lies in the ball by less";
  }
}

TEST(SurfaceDistance, OfNoSurface) {
  EXPECT_EQ(SurfaceDistance(Mesh{}).to({0, 0, 0}), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace sheen
