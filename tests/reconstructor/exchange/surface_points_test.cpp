// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/exchange/surface_points.h"

#include <gtest/gtest.h>

#include "common/base/files.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

const Camera kCamera{.width = 200, .height = 200, .fx = 200, .fy = 200, .cx = 99.5, .cy = 99.5};

ImageU8 picture_of(std::uint8_t red) {
  ImageU8 picture(200, 200, 3, 10);
  for (std::size_t i = 0; i < picture.size(); i += 3) picture.data()[i] = red;
  return picture;
}

TEST(SurfacePointsTest, HaveTheMeanOfWhatIsSeenAndOnlyOfThat) {
  SurfacePoints points(sphere_mesh(0.1f, 3));
  const PosedCamera front{kCamera, look_at({0, 0, 0.5}, {0, 0, 0}, {0, 1, 0})};
  points.look(picture_of(100), {}, front);
  points.look(picture_of(200), {}, front);
  points.look(picture_of(250), ImageU8(200, 200, 1), front);  // a mask without object
  int seen = 0;
  for (const ColouredPoint& point : points.points()) {
    EXPECT_NEAR(point.position.norm(), 0.1, 1e-6);
    const bool towards = point.position.z() > 0.05, away = point.position.z() < 0;
    if (towards) EXPECT_EQ(point.colour, (std::array<std::uint8_t, 3>{150, 10, 10}));
    if (away) EXPECT_EQ(point.colour, (std::array<std::uint8_t, 3>{128, 128, 128})) << "grey: unseen";
    seen += towards;
  }
  EXPECT_GT(seen, 100);
}

TEST(SurfacePointsTest, WhatStandsInFrontHides) {
  Mesh mesh = square_mesh(0.1f, 0, 4);
  const std::size_t behind = mesh.vertices.size();
  SurfacePoints points(joined(mesh, square_mesh(0.2f, 0.2f, 1)));
  points.look(picture_of(200), {}, {kCamera, look_at({0, 0, 0.8}, {0, 0, 0}, {0, 1, 0})});
  const std::vector<ColouredPoint> all = points.points();
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i].colour[0], i < behind ? 128 : 200) << i;
}

TEST(SurfacePointsTest, StandWhereTheMeshsFileHasThem) {
  Mesh mesh = sphere_mesh(0.1f, 1);
  mesh.origin = {4e6, 5e5, 100};
  SurfacePoints points(mesh);
  const Eigen::Vector3d eye = mesh.origin + Eigen::Vector3d(0, 0, 0.5);
  points.look(picture_of(77), {}, {kCamera, look_at(eye, mesh.origin, {0, 1, 0})});
  int seen = 0;
  for (const ColouredPoint& point : points.points()) {
    EXPECT_NEAR((point.position - mesh.origin).norm(), 0.1, 1e-6);
    seen += point.colour[0] == 77;
  }
  EXPECT_GT(seen, 5);
}

TEST(SurfacePointsTest, AreWrittenAsPly) {
  const TempFolder temp;
  const auto file = temp.path() / "points.ply";
  write_point_cloud(file, {{{1, 2, 3}, {4, 5, 6}}, {{0, 0, 0}, {255, 0, 0}}});
  const std::string bytes = read_file(file);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty double x\nproperty double y\nproperty double "
      "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  ASSERT_TRUE(bytes.starts_with(header));
  EXPECT_EQ(bytes.size(), header.size() + 2 * 27);
  EXPECT_EQ(bytes.substr(header.size() + 24, 3), "\x04\x05\x06");
}

}  // namespace
}  // namespace sheen
