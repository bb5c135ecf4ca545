// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_column.h"

#include <gtest/gtest.h>

#include "common/image/color.h"

namespace sheen {
namespace {

/// Two triangles that share the edge of vertices 0 and 2; an image shows sample s of all triangles at pixel (s + 2, 3).
class PatchColumnTest : public testing::Test {
 protected:
  static float level(int x, int, int c) { return 0.02f * static_cast<float>(x) + 0.1f * static_cast<float>(c); }
  /// At the samples, which stand in the middle of pixels.
  static Eigen::Vector3f colour(int s) {
    constexpr int kX[] = {2, 6, 6, 2, 2, 2, 4, 4, 6}, kY[] = {1, 5, 1, 1, 3, 5, 3, 5, 5};
    return Eigen::Vector3f(level(kX[s], kY[s], 0), level(kX[s], kY[s], 1), level(kX[s], kY[s], 2))
        .unaryExpr([](float v) { return srgb_encode(v); });
  }
  SurfaceImage shown() const { return {image_, view_, maps_, 1, Sampling::kCubic}; }

  PatchColumnTest() {
    const std::size_t samples = maps_.total_samples();
    ImageF image(16, 8, 3);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 16; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = level(x, y, c);
    image_ = RadianceImage(image);
    places_.use({.width = 16, .height = 8, .fx = 1, .fy = 1}, {});
    view_.places = &places_;
    view_.step_px = {1, 1};
    view_.eye = {0, 0, 2};
    view_.visible.assign(samples, 0);
    view_.visible_in_triangle = {0, 0};
    view_.cosine = {0.9f, 0.4f};
  }

  Mesh mesh_{.vertices = {{2, 1, 1}, {6, 1, 1}, {6, 5, 1}, {2, 5, 1}}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  MapLayout maps_{{2, 3}};  // 3 and 6 samples
  PatchShapes whole_ = cut_into_patches(mesh_, maps_, {.triangles = 2}),
              apart_ = cut_into_patches(mesh_, maps_, {.triangles = 1});
  SampleProjection places_{mesh_, maps_};
  RadianceImage image_;
  SurfaceView view_;
  PatchColumn column_;
};

TEST_F(PatchColumnTest, HoldsTheSamplesOfThePatchsTrianglesInTheirOrder) {
  view_.visible = {1, 0, 0, 0, 0, 1, 0, 0, 0};
  view_.visible_in_triangle = {1, 1};
  ASSERT_TRUE(gather(whole_.patches[0], shown(), column_));
  ASSERT_EQ(column_.values.size(), 27);
  EXPECT_EQ(column_.visible, view_.visible);
  for (const int s : {0, 5}) EXPECT_LT((column_.values.segment<3>(3 * s) - colour(s)).norm(), 1e-4f) << s;

  ASSERT_TRUE(gather(apart_.patches[1], shown(), column_));
  ASSERT_EQ(column_.values.size(), 18);
  EXPECT_EQ(column_.visible, (std::vector<std::uint8_t>{0, 0, 1, 0, 0, 0}));
  EXPECT_LT((column_.values.segment<3>(6) - colour(5)).norm(), 1e-4f);
}

TEST_F(PatchColumnTest, AViewIsReliedOnAtAVertexAsFarAsItShowsTheTrianglesRoundIt) {
  view_.visible = {1, 1, 1, 0, 0, 1, 1, 1, 0};
  view_.visible_in_triangle = {3, 3};
  const std::vector<float> both = reliability_at_vertices(mesh_, maps_, view_);
  EXPECT_FLOAT_EQ(both[0], 0.9f * 6 / 9);
  EXPECT_FLOAT_EQ(both[1], 0.9f) << "the first triangle alone";
  EXPECT_FLOAT_EQ(both[3], 0.4f * 3 / 6) << "the second alone";
  view_.visible_in_triangle = {0, 3};
  const std::vector<float> second = reliability_at_vertices(mesh_, maps_, view_);
  EXPECT_FLOAT_EQ(second[2], 0.4f * 3 / 9) << "the first triangle, seen more squarely, shows nothing";
  EXPECT_GT(second[1], 0);
  EXPECT_LT(second[1], 0.01f);
}

TEST_F(PatchColumnTest, APatchThatTheImageDoesNotShowHasNoColumn) {
  view_.visible[0] = 1;
  view_.visible_in_triangle = {1, 0};
  EXPECT_FALSE(gather(apart_.patches[1], shown(), column_));
  EXPECT_EQ(column_.values.size(), 0);
}

}  // namespace
}  // namespace sheen
