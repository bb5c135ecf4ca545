// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"
#include "reconstructor/models/intrinsic_lumigraph/plane_sweep.h"

namespace sheen {
namespace {

constexpr int kWidth = 80, kHeight = 60;

PosedCamera camera_at(double x, double y) {
  return {{.width = kWidth, .height = kHeight, .fx = 100, .fy = 100, .cx = 39.5, .cy = 29.5},
          {Eigen::Quaterniond::Identity(), {-x, -y, 1}}};
}

/// A wall z = 1 + slope x before the cameras (their frame), with a smooth pattern, in closed form.
struct Wall {
  double slope = 0;
  double depth(int px, const PosedCamera& from) const {
    const double u = (px - from.camera.cx) / from.camera.fx, x0 = -from.camera_from_object.translation.x();
    return (1 + slope * x0) / (1 - slope * u);
  }
  ImageF picture(const PosedCamera& from) const {
    ImageF image(kWidth, kHeight, 1);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double z = depth(x, from), wx = z * (x - from.camera.cx) / 100 - from.camera_from_object.translation.x(),
                     wy = z * (y - from.camera.cy) / 100 - from.camera_from_object.translation.y();
        image.at(x, y) =
            static_cast<float>(0.5 + 0.15 * std::sin(90 * wx + 20 * wy) + 0.15 * std::sin(110 * wy - 40 * wx));
      }
    return image;
  }
};

struct Swept {
  ImageF chosen, refined;
};
Swept swept(const Wall& wall) {
  const PosedCamera own = camera_at(0, 0);
  std::vector<ImageF> pictures;
  std::vector<PosedCamera> cameras;
  for (const auto& [x, y] : {std::pair{0.03, 0.0}, {-0.03, 0.0}, {0.0, 0.03}, {0.0, -0.03}}) {
    cameras.push_back(camera_at(x, y));
    pictures.push_back(wall.picture(cameras.back()));
  }
  std::vector<SweepImage> others;
  for (std::size_t i = 0; i < cameras.size(); ++i) others.push_back({cameras[i], &pictures[i]});
  const ImageF grey = wall.picture(own);
  const std::vector<double> planes = sweep_planes(own, others, 0.7, 1.5);
  const SweepCosts costs({own, &grey}, others, planes);
  RefinedDepth refined(planes, costs.best_planes());
  refined.add({own, &grey}, others);
  return {costs.depth(), refined.depth()};
}

double worst_error(const ImageF& depth, const Wall& wall) {
  double worst = 0;
  for (int y = 10; y < kHeight - 10; ++y)
    for (int x = 10; x < kWidth - 10; ++x)
      worst = std::max(worst, std::abs(depth.at(x, y) / wall.depth(x, camera_at(0, 0)) - 1));
  return worst;
}

TEST(PlaneSweepTest, FindsAWall) {
  for (const double slope : {0.0, 0.3}) {
    const Swept depth = swept({slope});
    EXPECT_LT(worst_error(depth.chosen, {slope}), slope == 0 ? 0.02 : 0.04) << "slope " << slope;
    EXPECT_LT(worst_error(depth.refined, {slope}), slope == 0 ? 0.005 : 0.015) << "slope " << slope;
  }
}

TEST(PlaneSweepTest, PlanesAreEvenInInverseDepth) {
  const PosedCamera own = camera_at(0, 0);
  const std::vector<SweepImage> others{{camera_at(0.1, 0), nullptr}};
  const std::vector<double> planes = sweep_planes(own, others, 0.5, 2);
  EXPECT_DOUBLE_EQ(planes.front(), 0.5);
  EXPECT_NEAR(planes.back(), 2, 1e-12);
  for (std::size_t p = 2; p < planes.size(); ++p)
    EXPECT_NEAR(1 / planes[p] - 1 / planes[p - 1], 1 / planes[1] - 1 / planes[0], 1e-9);
  EXPECT_LE(100 * 0.1 * std::abs(1 / planes[1] - 1 / planes[0]), 0.75) << "pixels from plane to plane";
}

TEST(NeighboursTest, StandAllRound) {
  std::vector<PosedCamera> grid;
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) grid.push_back(camera_at(0.1 * x, 0.1 * y));
  const std::vector<std::size_t> taken = spread_neighbours(grid, 12);
  ASSERT_EQ(taken.size(), 8u);
  int left = 0, above = 0;
  for (const std::size_t v : taken) {
    left += v % 5 < 2;
    above += v / 5 < 2;
  }
  EXPECT_GE(left, 2);
  EXPECT_GE(above, 2);
  EXPECT_EQ(spread_neighbours(std::span(grid).first(3), 1).size(), 2u);
}

TEST(ViewPlaneTest, IsToldFromOtherMeshes) {
  const Mesh plane = view_plane(camera_at(0, 0));
  EXPECT_TRUE(is_view_plane(plane));
  Mesh square = plane;
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_FALSE(is_view_plane(square));
  for (const Eigen::Vector3f& corner : plane.vertices)
    EXPECT_NEAR(corner.z(), 0, 1e-6) << "through the object's origin";
}

}  // namespace
}  // namespace sheen
