// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/polygon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

namespace sheen {
namespace {

using Polygon = std::vector<Eigen::Vector3d>;
using Corners = std::array<std::uint32_t, 3>;

/// By Green's theorem: along the normal, twice.
Eigen::Vector3d double_area(const Polygon& polygon) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i) sum += polygon[i].cross(polygon[(i + 1) % polygon.size()]);
  return sum;
}

/// As many triangles as there have to be, which lie side by side: as much surface as the polygon encloses, none turned
/// over.
void expect_covered(const Polygon& polygon) {
  const std::vector<Corners> triangles = polygon_triangles(polygon);
  ASSERT_EQ(triangles.size(), polygon.size() - 2);
  const Eigen::Vector3d whole = double_area(polygon);
  double area = 0;
  for (const auto& [a, b, c] : triangles) {
    const Eigen::Vector3d part = (polygon[b] - polygon[a]).cross(polygon[c] - polygon[a]);
    EXPECT_GE(part.dot(whole), -1e-9 * whole.squaredNorm());
    area += part.norm();
  }
  EXPECT_NEAR(area, whole.norm(), 1e-9 * whole.norm());
}

/// Turned and moved, either side up, from any corner on.
void expect_covered_however_it_lies(Polygon polygon) {
  const Eigen::Quaterniond turned = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized();
  for (std::size_t first = 0; first < polygon.size(); ++first) {
    std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
    expect_covered(polygon);
    Polygon other;
    for (const Eigen::Vector3d& corner : polygon) other.push_back(turned * corner + Eigen::Vector3d(5, -3, 2));
    expect_covered(other);
    std::reverse(other.begin(), other.end());
    expect_covered(other);
  }
}

TEST(Polygon, AConvexOneIsAFan) {
  const std::vector<Corners> triangles =
      polygon_triangles(Polygon{{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}});
  EXPECT_THAT(triangles, testing::ElementsAre(Corners{0, 1, 2}, Corners{0, 2, 3}, Corners{0, 3, 4}));
}

TEST(Polygon, ConcaveOnes) {
  expect_covered_however_it_lies({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}});  // L
  expect_covered_however_it_lies({{0, 0, 0}, {2, -1, 0}, {0.5, 0, 0}, {2, 1, 0}});                     // arrow
  Polygon comb{{0, 0, 0}};
  for (int tooth = 0; tooth < 12; ++tooth)
    comb.insert(comb.end(), {{tooth + 1.0, 0, 0}, {tooth + 0.9, 5, 0}, {tooth + 1.0, 0.1, 0}});
  comb.insert(comb.end(), {{12, 6, 0}, {0, 6, 0}});
  expect_covered({comb.rbegin(), comb.rend()});
  Polygon spiral;
  for (int i = 0; i <= 200; ++i)
    spiral.emplace_back((1 + 0.02 * i) * std::cos(0.1 * i), (1 + 0.02 * i) * std::sin(0.1 * i), 0);
  for (int i = 200; i >= 0; --i)
    spiral.emplace_back((1.3 + 0.02 * i) * std::cos(0.1 * i), (1.3 + 0.02 * i) * std::sin(0.1 * i), 0);
  expect_covered(spiral);
}

TEST(Polygon, StarsOfAnyShape) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> radius(0.1, 1), lift(-0.001, 0.001);
  for (int trial = 0; trial < 300; ++trial) {
    Polygon star;
    const int corners = 4 + trial % 40;
    for (int i = 0; i < corners; ++i) {
      const double r = radius(random), angle = 2 * M_PI * i / corners;
      star.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    expect_covered(star);
  }
}

TEST(Polygon, CornersInLineAndRepeatedOnes) {
  expect_covered_however_it_lies({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {0, 2, 0}});
  expect_covered_however_it_lies({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 2, 0}});
  expect_covered_however_it_lies({{0, 0, 0}, {0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {2, 2, 0}, {1, 0.5, 0}});
  expect_covered_however_it_lies(
      {{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {3, 2, 0}, {3, 1, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}});
}

/// Formats without holes have a bridge to them, there and back.
TEST(Polygon, ABridgeToAHole) {
  expect_covered_however_it_lies({{0, 0, 0},
                                  {4, 0, 0},
                                  {4, 4, 0},
                                  {0, 4, 0},
                                  {0, 0, 0},  // outline
                                  {1, 1, 0},
                                  {1, 3, 0},
                                  {3, 3, 0},
                                  {3, 1, 0},
                                  {1, 1, 0}});
  expect_covered_however_it_lies({{0, 0, 0},
                                  {4, 0, 0},
                                  {4, 2, 0},
                                  {3, 2, 0},
                                  {2, 1, 0},
                                  {1, 2, 0},
                                  {2, 3, 0},
                                  {3, 2, 0},
                                  {4, 2, 0},
                                  {4, 4, 0},
                                  {0, 4, 0}});
}

TEST(Polygon, WhatEnclosesNothingIsSplitAllTheSame) {
  EXPECT_EQ(polygon_triangles(Polygon(5, {1, 2, 3})).size(), 3u);
  EXPECT_EQ(polygon_triangles(Polygon{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2u) << "crosses itself";
  Polygon star;
  for (int i = 0; i < 5; ++i) star.emplace_back(std::cos(0.8 * M_PI * i), std::sin(0.8 * M_PI * i), 0);
  EXPECT_EQ(polygon_triangles(star).size(), 3u) << "goes round twice";
  EXPECT_TRUE(polygon_triangles(Polygon{{0, 0, 0}, {1, 0, 0}}).empty());
}

TEST(Polygon, ManyCornersAreForConvexOnesOnly) {
  Polygon circle;
  for (std::size_t i = 0; i <= kMostCorners; ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / static_cast<double>(kMostCorners + 1);
    circle.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  EXPECT_EQ(polygon_triangles(circle).size(), kMostCorners - 1);
  circle[0] *= 0.5;
  EXPECT_TRUE(polygon_triangles(circle).empty());
  circle.pop_back();
  expect_covered(circle);
}

}  // namespace
}  // namespace sheen
