// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/studies/shadow_warp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sheen {
namespace {

constexpr int kWidth = 160, kHeight = 120;

struct Ellipse {
  double x = 0, y = 0, half_length = 0, half_width = 0, turn = 0;
  bool holds(double px, double py) const {
    const double dx = px - x, dy = py - y, along = std::cos(turn) * dx + std::sin(turn) * dy,
                 across = std::cos(turn) * dy - std::sin(turn) * dx;
    return std::hypot(along / half_length, across / half_width) < 1;
  }
};

ImageU8 mask_of(const std::vector<Ellipse>& ellipses) {
  ImageU8 mask(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (const Ellipse& ellipse : ellipses)
        if (ellipse.holds(x, y)) mask.at(x, y) = 255;
  return mask;
}

double iou(const ImageU8& a, const ImageU8& b) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    both += a.data()[i] >= 128 && b.data()[i] >= 128;
    either += a.data()[i] >= 128 || b.data()[i] >= 128;
  }
  return both / either;
}

/// Two shadows that move, turn and grow, each its own way.
std::vector<Ellipse> shadows_at(double part) {
  return {{40 + 20 * part, 40, 18 + 8 * part, 8, 0.5 * part},
          {110, 80 - 15 * part, 14, 9 + 3 * part, 1.2 - 0.6 * part}};
}

TEST(ShadowWarp, FollowsWhatMovesTurnsAndGrows) {
  std::vector<ImageU8> geometric;
  for (int k = 0; k <= 6; ++k) geometric.push_back(mask_of(shadows_at(k / 6.0)));
  const std::vector<ImageU8> shadows = warped_shadows(geometric, geometric.front(), geometric.back());
  ASSERT_EQ(shadows.size(), 7u);
  EXPECT_LT(iou(geometric[0], geometric[3]), 0.75) << "there is something to follow";
  for (std::size_t k = 0; k < 7; ++k) EXPECT_GT(iou(shadows[k], geometric[k]), 0.93) << k;
}

TEST(ShadowWarp, ShapesAreThoseOfTheImages) {
  // The depth map makes shadows that are too large; those of the images are moved as they are.
  std::vector<ImageU8> geometric, images;
  for (int k = 0; k <= 4; ++k) {
    const double x = 40 + 10.0 * k;
    geometric.push_back(mask_of({{x, 60, 20, 14, 0}}));
    images.push_back(mask_of({{x, 60, 16, 9, 0}}));
  }
  const std::vector<ImageU8> shadows = warped_shadows(geometric, images.front(), images.back());
  EXPECT_GT(iou(shadows[2], images[2]), 0.95);
}

TEST(ShadowWarp, WhatNoGeometryCastsIsNoShadow) {
  const ImageU8 cast = mask_of({{40, 60, 15, 10, 0}}),
                with_paint = mask_of({{40, 60, 15, 10, 0}, {120, 60, 12, 12, 0}});
  const std::vector<ImageU8> shadows = warped_shadows(std::vector<ImageU8>(3, cast), with_paint, with_paint);
  for (const ImageU8& shadow : shadows) EXPECT_GT(iou(shadow, cast), 0.99);
}

TEST(ShadowWarp, WithoutGeometricShadowsThereAreNone) {
  const std::vector<ImageU8> shadows = warped_shadows(std::vector<ImageU8>(3, ImageU8(kWidth, kHeight, 1)),
                                                      mask_of(shadows_at(0)), mask_of(shadows_at(1)));
  for (const ImageU8& shadow : shadows) EXPECT_EQ(shadow, ImageU8(kWidth, kHeight, 1));
}

TEST(DepthSurface, IsTornAtJumpsAndWhereNothingIsKnown) {
  PosedCamera from;
  from.camera = {.width = 12, .height = 8, .fx = 100, .fy = 100, .cx = 5.5, .cy = 3.5};
  ImageF depth(12, 8, 1, 1.0f);
  const std::size_t whole = 2 * 11 * 7;
  EXPECT_EQ(depth_surface(from, depth).triangles.size(), whole);
  for (int y = 0; y < 8; ++y)
    for (int x = 6; x < 12; ++x) depth.at(x, y) = 1.2f;
  const Mesh torn = depth_surface(from, depth);
  EXPECT_EQ(torn.triangles.size(), whole - 2 * 7);
  for (std::size_t t = 0; t < torn.triangles.size(); ++t) EXPECT_LT(torn.area_normal(t).z(), 0) << "towards the eye";
  depth.at(2, 2) = 0;
  EXPECT_EQ(depth_surface(from, depth).triangles.size(), whole - 2 * 7 - 6);
}

}  // namespace
}  // namespace sheen
