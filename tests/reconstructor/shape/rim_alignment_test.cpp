// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/rim_alignment.h"

#include <gtest/gtest.h>

#include "tests/reconstructor/refinement/ball_photographs.h"

namespace sheen {
namespace {

/// With the ball's outline in each.
std::vector<ShapeView> views_of_ball(int count, double lowest) {
  const Photographs photographs(ball(), count, lowest, true);
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < photographs.images().cameras.size(); ++i)
    views.push_back(colour_view(photographs.images().read(i), {0, 0, kCamera.width, kCamera.height}, 1).view);
  return views;
}

Mesh ball_mesh(double off_px) {
  Mesh mesh = sphere_mesh(kRadius, 5);
  for (Eigen::Vector3f& v : mesh.vertices) v *= static_cast<float>(1 + off_px * kPixel / kRadius);
  return mesh;
}

TEST(RimAlignment, ABallThatIsTooSmallOrTooLargeFillsItsOutlines) {
  const std::vector<ShapeView> views = views_of_ball(40, -0.98);
  for (const double off_px : {-0.8, 0.8}) {
    Mesh mesh = ball_mesh(off_px);
    move_rims_to_outlines(views, kPixel, mesh);
    EXPECT_LT(rms_from_ball(mesh), 0.35 * kPixel) << off_px;
  }
}

TEST(RimAlignment, GoesNoFartherThanTwoPixels) {
  const std::vector<ShapeView> views = views_of_ball(40, -0.98);
  const Mesh before = ball_mesh(-2.9);
  Mesh mesh = before;
  move_rims_to_outlines(views, kPixel, mesh);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    EXPECT_LE((mesh.vertices[v] - before.vertices[v]).norm(), 2.001 * kPixel);
}

TEST(RimAlignment, WhatIsOnNoRimStays) {
  std::vector<ShapeView> views = views_of_ball(1, 0.98);  // from above
  const Mesh before = ball_mesh(-0.8);
  Mesh mesh = before;
  move_rims_to_outlines(views, kPixel, mesh);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (std::abs(before.vertices[v].z()) > 0.9 * kRadius) EXPECT_EQ(mesh.vertices[v], before.vertices[v]);
  views.front().outline = {};
  Mesh same = before;
  move_rims_to_outlines(views, kPixel, same);
  EXPECT_EQ(same.vertices, before.vertices) << "without outlines";
}

}  // namespace
}  // namespace sheen
