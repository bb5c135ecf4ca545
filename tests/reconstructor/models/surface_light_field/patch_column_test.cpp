// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_column.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

/// Two triangles that share the edge of vertices 0 and 2; sample s of all triangles has the colour (s, s + 0.1, s +
/// 0.2).
class PatchColumnTest : public testing::Test {
 protected:
  PatchColumnTest() {
    const std::size_t samples = maps_.total_samples();
    encoded_.resize(3, static_cast<Eigen::Index>(samples));
    for (Eigen::Index s = 0; s < encoded_.cols(); ++s)
      encoded_.col(s) = Eigen::Vector3f(0, 0.1f, 0.2f).array() + static_cast<float>(s);
    view_.eye = {0, 0, 2};
    view_.visible.assign(samples, 0);
    view_.first = {0, 3};
    view_.visible_in_triangle = {0, 0};
    view_.cosine = {0.9f, 0.4f};
  }

  Mesh mesh_{.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  MapLayout maps_{{2, 3}};  // 3 and 6 samples
  PatchShapes whole_ = cut_into_patches(mesh_, maps_, 2), apart_ = cut_into_patches(mesh_, maps_, 1);
  Eigen::Matrix3Xf encoded_;
  SurfaceView view_;
  PatchColumn column_;
};

TEST_F(PatchColumnTest, HoldsTheSamplesOfThePatchsTrianglesInTheirOrder) {
  view_.visible = {1, 0, 0, 0, 0, 1, 0, 0, 0};
  view_.visible_in_triangle = {1, 1};
  ASSERT_TRUE(gather(maps_, whole_.patches[0], {view_, encoded_}, column_));
  ASSERT_EQ(column_.values.size(), 27);
  EXPECT_EQ(column_.visible, view_.visible);
  for (Eigen::Index s = 0; s < 9; ++s) EXPECT_EQ(column_.values.segment<3>(3 * s), encoded_.col(s)) << s;

  ASSERT_TRUE(gather(maps_, apart_.patches[1], {view_, encoded_}, column_));
  ASSERT_EQ(column_.values.size(), 18);
  EXPECT_EQ(column_.visible, (std::vector<std::uint8_t>{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(column_.values.head<3>(), encoded_.col(3));
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
  EXPECT_FALSE(gather(maps_, apart_.patches[1], {view_, encoded_}, column_));
  EXPECT_EQ(column_.values.size(), 0);
}

}  // namespace
}  // namespace sheen
