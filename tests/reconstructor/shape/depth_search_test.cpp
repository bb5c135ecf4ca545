// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/depth_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "common/base/order_statistics.h"
#include "reconstructor/shape/neighbour_views.h"
#include "reconstructor/shape/window_matcher.h"
#include "tests/reconstructor/refinement/ball_photographs.h"

namespace sheen {
namespace {

/// A ball, what is to be searched, and its exact depths.
struct BallViews {
  BallViews() : photographs(ball(), 60, -0.98, false) {
    for (std::size_t i = 0; i < 60; ++i) {
      views.push_back(colour_view(photographs.images().read(i), {0, 0, kCamera.width, kCamera.height}, 1).view);
      truth.push_back(exact(views.back()));
    }
    const auto chosen = neighbour_views(photographs.images().cameras, Eigen::Vector3d::Zero(), 5);
    for (const std::size_t j : chosen[0]) {
      neighbours.push_back(&views[j]);
      depths.push_back(&truth[j].depth);
    }
    range = {ImageF(kCamera.width, kCamera.height, 1), ImageF(kCamera.width, kCamera.height, 1)};
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x)
        if (truth[0].depth.at(x, y) > 0) range.nearest.at(x, y) = 0.38f, range.farthest.at(x, y) = 0.52f;
  }

  static DepthMap exact(const ShapeView& view) {
    DepthMap map{ImageF(kCamera.width, kCamera.height, 1), ImageF(kCamera.width, kCamera.height, 3),
                 ImageF(kCamera.width, kCamera.height, 1)};
    const Rigid3 object_from_view = view.camera.camera_from_object.inverse();
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x) {
        const Eigen::Vector3d ray = *kCamera.ray({double(x), double(y)});
        const double t = analytic::sphere(kRadius)(object_from_view.translation, object_from_view.rotation * ray);
        if (!(t < analytic::kMiss)) continue;
        map.depth.at(x, y) = static_cast<float>(t * ray.z());
        const Eigen::Vector3d normal =
            view.camera.camera_from_object.rotation *
            (object_from_view.translation + object_from_view.rotation * (t * ray)).normalized();
        Eigen::Map<Eigen::Vector3f>(map.normal.pixel(x, y)) = normal.cast<float>();
      }
    return map;
  }

  Photographs photographs;
  std::vector<ShapeView> views;
  std::vector<DepthMap> truth;
  std::vector<const ShapeView*> neighbours;
  std::vector<const ImageF*> depths;
  DepthRange range;
};

TEST(NeighbourViews, AreFromNearbyDirectionsOnDifferentSides) {
  const BallViews ball;
  ASSERT_EQ(ball.neighbours.size(), 5u);
  const auto direction = [](const ShapeView& view) {
    return camera_centre(view.camera.camera_from_object).normalized();
  };
  Eigen::Vector3d sides = Eigen::Vector3d::Zero();
  for (const ShapeView* view : ball.neighbours) {
    const double cosine = direction(*view).dot(direction(ball.views[0]));
    EXPECT_GT(cosine, std::cos(45 * M_PI / 180));
    sides += (direction(*view) - direction(ball.views[0])).normalized();
  }
  EXPECT_LT(sides.norm(), 3);
}

TEST(WindowMatcher, IsBestAtTheSurface) {
  const BallViews ball;
  WindowMatcher matcher(ball.views[0], ball.neighbours);
  int tried = 0, best = 0;
  for (int y = 40; y < 160; y += 7)
    for (int x = 60; x < 180; x += 7) {
      const float depth = ball.truth[0].depth.at(x, y);
      const Eigen::Map<const Eigen::Vector3f> normal(ball.truth[0].normal.pixel(x, y));
      if (!(depth > 0) || !(normal.z() < -0.6f) || !matcher.take(x, y)) continue;
      const float there = matcher.cost({depth, normal}), off = 3 * matcher.depth_per_pixel(depth);
      ++tried;
      best +=
          there < 0.05f && there < matcher.cost({depth + off, normal}) && there < matcher.cost({depth - off, normal});
    }
  ASSERT_GT(tried, 80);
  EXPECT_GT(best, 0.97 * tried);
}

/// The normalised cross-correlation of a slanted window with one other view, by its definition; 2 where the window
/// leaves that view.
double plain_cost(const ShapeView& view, const ShapeView& other, int x, int y, const SurfacePiece& piece) {
  const Camera &camera = view.camera.camera, &other_camera = other.camera.camera;
  const auto ray_of = [&](double u, double v) -> Eigen::Vector3d {
    return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1};
  };
  const Eigen::Vector3d normal = piece.normal.cast<double>();
  const double plane = normal.dot(piece.depth * ray_of(x, y));
  const Rigid3 other_from_view = other.camera.camera_from_object * view.camera.camera_from_object.inverse();
  double w = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int dy = -4; dy <= 4; dy += 2)
    for (int dx = -4; dx <= 4; dx += 2) {
      const Eigen::Vector3d ray = ray_of(x + dx, y + dy), there = other_from_view * (plane / normal.dot(ray) * ray);
      const double u = other_camera.fx * there.x() / there.z() + other_camera.cx,
                   v = other_camera.fy * there.y() / there.z() + other_camera.cy;
      if (!(there.z() > 0 && u >= 0 && v >= 0 && u < other.grey.width() - 1 && v < other.grey.height() - 1)) return 2;
      const int i = static_cast<int>(u), j = static_cast<int>(v);
      const double s = u - i, t = v - j;
      const double value = (1 - t) * ((1 - s) * other.grey.at(i, j) + s * other.grey.at(i + 1, j)) +
                           t * ((1 - s) * other.grey.at(i, j + 1) + s * other.grey.at(i + 1, j + 1));
      const double own = view.grey.at(x + dx, y + dy), off = (own - view.grey.at(x, y)) / 60;
      const double weight = 1 / (1 + off * off + 0.5 * (dx * dx + dy * dy) / 4);
      w += weight, a += weight * own, b += weight * value;
      aa += weight * own * own, bb += weight * value * value, ab += weight * own * value;
    }
  a /= w, b /= w, aa /= w, bb /= w, ab /= w;
  return std::min(2.0, 1 - (ab - a * b) / std::sqrt((aa - a * a + 4) * (bb - b * b + 4)));
}

TEST(WindowMatcher, CostsWhatTheDefinitionSays) {
  const BallViews ball;
  WindowMatcher matcher(ball.views[0], ball.neighbours);
  std::mt19937 chance(1);
  std::normal_distribution<float> some;
  int tried = 0;
  for (int y = 20; y < 180; y += 5)
    for (int x = 40; x < 200; x += 5) {
      const float depth = ball.truth[0].depth.at(x, y);
      if (!(depth > 0) || !matcher.take(x, y)) continue;
      const Eigen::Vector3f towards = -matcher.ray(static_cast<float>(x), static_cast<float>(y)).normalized();
      const SurfacePiece piece{
          depth + 5 * some(chance) * matcher.depth_per_pixel(depth),
          (towards + 0.3f * Eigen::Vector3f(some(chance), some(chance), some(chance))).normalized()};
      std::vector<double> costs;
      for (const ShapeView* other : ball.neighbours) costs.push_back(plain_cost(ball.views[0], *other, x, y, piece));
      std::sort(costs.begin(), costs.end());
      const double plain = (costs[0] + costs[1] + costs[2]) / 3;
      const float cost = matcher.cost(piece);
      EXPECT_NEAR(cost, plain, 2e-3) << x << ", " << y;
      // What is enough is found as without it, and else it is not said to be better.
      EXPECT_EQ(matcher.cost(piece, 1.01f * cost), cost);
      EXPECT_GE(matcher.cost(piece, 0.7f * cost), 0.7f * cost);
      ++tried;
    }
  EXPECT_GT(tried, 500);
}

TEST(WindowMatcher, FindsItsWayBackOnExactSurfaces) {
  const BallViews ball;
  const WindowMatcher matcher(ball.views[0], ball.neighbours, ball.depths);
  const int x = 120, y = 100;
  const float depth = ball.truth[0].depth.at(x, y);
  for (std::size_t i = 0; i < ball.neighbours.size(); ++i) {
    const auto back = matcher.way_back(i, x, y, depth);
    ASSERT_TRUE(back);
    EXPECT_LT(back->pixels, 0.5f);
    EXPECT_LT(back->depth_off, 0.002f);
    const auto wrong = matcher.way_back(i, x, y, depth + 8 * matcher.depth_per_pixel(depth));
    EXPECT_TRUE(!wrong || wrong->pixels > 2);
  }
}

TEST(SearchDepth, FindsTheBall) {
  const BallViews ball;
  DepthMap found = search_depth(ball.views[0], ball.neighbours, ball.range, 1);
  found = search_depth_again(ball.views[0], ball.neighbours, ball.depths, ball.range, std::move(found), 2);
  const ImageU8 agreeing = agreeing_neighbours(ball.views[0], found, ball.neighbours, ball.depths);
  std::vector<double> off;
  std::size_t kept = 0, facing = 0;
  for (int y = 0; y < kCamera.height; ++y)
    for (int x = 0; x < kCamera.width; ++x) {
      const float truth = ball.truth[0].depth.at(x, y);
      EXPECT_EQ(found.depth.at(x, y) > 0 && truth == 0, false) << "nothing is found out of range";
      if (!(truth > 0) || ball.truth[0].normal.at(x, y, 2) > -0.4f) continue;
      ++facing;
      if (agreeing.at(x, y) < 2) continue;
      ++kept;
      off.push_back(std::abs(found.depth.at(x, y) - truth));
    }
  EXPECT_GT(static_cast<double>(kept), 0.9 * static_cast<double>(facing));
  ASSERT_FALSE(off.empty());
  EXPECT_LT(quantile(off, 0.5), 0.25 * kPixel);
  EXPECT_LT(quantile(off, 0.9), kPixel);
}

}  // namespace
}  // namespace sheen
