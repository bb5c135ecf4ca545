// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/visual_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "reconstructor/shape/closed_surface.h"
#include "reconstructor/shape/outline_evidence.h"
#include "tests/reconstructor/refinement/ball_photographs.h"

namespace sheen {
namespace {

const Eigen::AlignedBox3d kBox(Eigen::Vector3d::Constant(-0.2), Eigen::Vector3d::Constant(0.2));

std::vector<ShapeView> whole_views(const Photographs& photographs) {
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < photographs.images().cameras.size(); ++i)
    views.push_back(colour_view(photographs.images().read(i), {0, 0, kCamera.width, kCamera.height}, 1).view);
  return views;
}

TEST(VisualHull, OfABallIsTheDistanceFromIt) {
  const Photographs photographs(ball(), 60, -0.98, true);
  const VisualHull hull(whole_views(photographs), kBox, {});
  EXPECT_EQ(hull.outlines(), 60);
  for (const Eigen::Vector3d& direction : analytic::eyes(50, 1, -0.98))
    for (const double off : {-0.03, -0.005, 0.0, 0.005, 0.03}) {
      // On the ray of sight that touches the ball. Between two directions of sight the hull stands out a little.
      const double distance = hull.distance((kRadius + off) * direction);
      EXPECT_LT(std::abs(distance - off), 0.6 * kPixel + 0.3 * std::abs(off) + 0.002) << off;
    }
}

TEST(VisualHull, ADissenterIsOutvoted) {
  const Photographs photographs(ball(), 30, -0.98, true);
  std::vector<ShapeView> views = whole_views(photographs);
  for (int x = 0; x < kCamera.width / 2; ++x)
    for (int y = 0; y < kCamera.height; ++y) views[3].outline.at(x, y) = 0;  // half of one mask is missing
  double lost = 0;
  const Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  lost = VisualHull(views, kBox, {}).distance(0.5 * kRadius * Eigen::Vector3d::UnitX()) +
         VisualHull(views, kBox, {}).distance(-0.5 * kRadius * Eigen::Vector3d::UnitX());
  EXPECT_GT(lost, -2 * 0.5 * kRadius) << "without dissenters half of the ball is gone";
  EXPECT_LT(VisualHull(views, kBox, {.most_dissent = 1}).distance(middle), -0.9 * kRadius);
}

TEST(VisualHull, SaysHowManyOutlinesTellOfAPlace) {
  const Photographs photographs(ball(), 30, -0.98, true);
  std::vector<ShapeView> views = whole_views(photographs);
  const Eigen::Vector3d middle = Eigen::Vector3d::Zero(), behind_all = Eigen::Vector3d::Constant(10);
  EXPECT_EQ(VisualHull(views, kBox, {}).at(middle).outlines, 30);
  EXPECT_LT(VisualHull(views, kBox, {}).at(behind_all).outlines, 30) << "not in each frame";
  // In all but two the middle is off the sheet.
  for (std::size_t i = 2; i < views.size(); ++i) {
    views[i].before_sheet = true;
    for (int x = kCamera.width / 2 - 5; x < kCamera.width / 2 + 5; ++x)
      for (int y = 0; y < kCamera.height; ++y) views[i].outline.at(x, y) = static_cast<std::uint8_t>(Outline::kUnknown);
  }
  EXPECT_EQ(VisualHull(views, kBox, {}).at(middle).outlines, 2);
}

TEST(VisualHull, WithoutOutlinesIsWhatHalfOfTheViewsSee) {
  const Photographs photographs(ball(), 30, -0.98, false);
  const VisualHull hull(whole_views(photographs),
                        Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-1), Eigen::Vector3d::Constant(1)), {});
  EXPECT_FALSE(hull.has_outlines());
  EXPECT_LT(hull.distance({0, 0, 0}), 0);
  EXPECT_GT(hull.distance({0.4, 0, 0}), 0);
}

TEST(HullField, AgreesWithTheHullAtEveryPoint) {
  const Photographs photographs(ball(), 20, -0.98, true);
  const VisualHull hull(whole_views(photographs), kBox, {});
  const BlockField field = hull_field(hull, lattice_over(kBox, 0.004), one_after_the_other);
  const Eigen::Array3i points = field.lattice().points;
  for (int z = 0; z < points.z(); z += 3)
    for (int y = 0; y < points.y(); y += 3)
      for (int x = 0; x < points.x(); x += 3) {
        const float distance = hull.distance(field.lattice().at({x, y, z}));
        ASSERT_EQ(distance < 0, field.at({x, y, z}) < 0) << distance;
      }
  EXPECT_LT(field.stored(), static_cast<std::size_t>(field.blocks().prod()) * 3 / 4);
}

ShapeView grey_view(const std::function<float(int x, int y)>& grey) {
  ShapeView view{.name = "view", .camera = {}, .grey = ImageF(100, 80, 1), .outline = {}};
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 100; ++x) view.grey.at(x, y) = grey(x, y);
  return view;
}
float disc(int x, int y) {
  return std::hypot(x - 50, y - 40) < 20 ? 160.0f : 12.0f;
}

TEST(PlainBackground, IsFoundWhereTheRimIsOfOneGrey) {
  EXPECT_TRUE(plain_background(grey_view(disc)).found);
  EXPECT_TRUE(plain_background(grey_view([](int x, int y) { return 255 - disc(x, y); })).found) << "a bright one";
  EXPECT_FALSE(plain_background(grey_view([](int x, int) { return 2.0f * static_cast<float>(x); })).found);
  EXPECT_FALSE(plain_background(grey_view([](int, int) { return 0.0f; })).found) << "no object";
  const auto cut = [](int x, int y) { return x < 60 ? 160.0f : disc(x, y) * 0 + 12; };
  EXPECT_FALSE(plain_background(grey_view(cut)).found) << "the object reaches over the rim";
}

TEST(PlainBackground, WhatIsAsDarkWithinTheObjectIsUnknown) {
  const auto holed = [](int x, int y) { return std::hypot(x - 50, y - 40) < 6 ? 12.0f : disc(x, y); };
  ShapeView view = grey_view(holed);
  const PlainBackground background = plain_background(view);
  ASSERT_TRUE(background.found);
  mark_background(background, view);
  EXPECT_EQ(view.outline.at(2, 2), static_cast<int>(Outline::kBackground));
  EXPECT_EQ(view.outline.at(50, 40), static_cast<int>(Outline::kUnknown));
  EXPECT_EQ(view.outline.at(50, 28), static_cast<int>(Outline::kObject));
}

}  // namespace
}  // namespace sheen
