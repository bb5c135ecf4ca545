// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_column.h"

#include <gtest/gtest.h>

namespace sheen {
namespace {

/// Two triangles that share the edge of vertices 0 and 2; sample s of all triangles has the colour (s, s + 0.1, s +
/// 0.2).
class RingColumnTest : public testing::Test {
 protected:
  RingColumnTest() {
    const std::size_t samples = rings_.total_samples();
    encoded_.resize(3, static_cast<Eigen::Index>(samples));
    for (Eigen::Index s = 0; s < encoded_.cols(); ++s)
      encoded_.col(s) = Eigen::Vector3f(0, 0.1f, 0.2f).array() + static_cast<float>(s);
    view_.eye = {0, 0, 2};
    view_.visible.assign(samples, 0);
    view_.visible_in_triangle = {0, 0};
    view_.cosine = {0.9f, 0.4f};
  }

  Mesh mesh_{.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  VertexRings rings_{mesh_, {2, 3}};  // 3 and 6 samples
  Eigen::Matrix3Xf encoded_;
  SurfaceView view_;
  RingColumn column_;
};

TEST_F(RingColumnTest, HoldsTheSamplesOfTheRingsTrianglesInTheRingsOrder) {
  view_.visible = {1, 0, 0, 0, 0, 1, 0, 0, 0};
  view_.visible_in_triangle = {1, 1};
  ASSERT_TRUE(gather(rings_, 0, mesh_.vertices[0], view_, encoded_, column_));
  ASSERT_EQ(column_.values.size(), 27);
  EXPECT_EQ(column_.visible, view_.visible);
  for (Eigen::Index s = 0; s < 9; ++s) EXPECT_EQ(column_.values.segment<3>(3 * s), encoded_.col(s)) << s;
  EXPECT_EQ(column_.direction, Eigen::Vector3f(0, 0, 1));

  // Vertex 3 belongs to the second triangle alone.
  ASSERT_TRUE(gather(rings_, 3, mesh_.vertices[3], view_, encoded_, column_));
  ASSERT_EQ(column_.values.size(), 18);
  EXPECT_EQ(column_.visible, (std::vector<std::uint8_t>{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(column_.values.head<3>(), encoded_.col(3));
  EXPECT_FLOAT_EQ(column_.cosine, 0.4f);
}

TEST_F(RingColumnTest, CosineIsOfVisibleTrianglesOnly) {
  view_.visible[5] = 1;
  view_.visible_in_triangle = {0, 1};
  ASSERT_TRUE(gather(rings_, 2, mesh_.vertices[2], view_, encoded_, column_));
  EXPECT_FLOAT_EQ(column_.cosine, 0.4f);  // the first triangle, seen more squarely, shows nothing
}

TEST_F(RingColumnTest, RingThatTheImageDoesNotShowHasNoColumn) {
  view_.visible[0] = 1;
  view_.visible_in_triangle = {1, 0};
  EXPECT_FALSE(gather(rings_, 3, mesh_.vertices[3], view_, encoded_, column_));
  EXPECT_EQ(column_.values.size(), 0);
}

}  // namespace
}  // namespace sheen
