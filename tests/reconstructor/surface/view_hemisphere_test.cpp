// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/view_hemisphere.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <Eigen/LU>
#include <numeric>

#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

Eigen::Matrix3Xf upper_directions(int n, std::uint32_t seed) {
  Eigen::Matrix3Xf d = gaussian_matrix(3, n, seed);
  d.row(2) = d.row(2).cwiseAbs();
  return d.colwise().normalized();
}

TEST(ViewHemisphere, TheFrameIsARotationThatLiftsTheNormal) {
  const Eigen::Vector3f normal = Eigen::Vector3f(0.3f, -0.5f, 0.8f).normalized();
  const Eigen::Matrix3f frame = hemisphere_frame(normal);
  EXPECT_NEAR((frame * frame.transpose() - Eigen::Matrix3f::Identity()).norm(), 0, 1e-5);
  EXPECT_NEAR((frame * normal - Eigen::Vector3f::UnitZ()).norm(), 0, 1e-5);
  EXPECT_NEAR(hemisphere_point(frame, -normal + 1e-3f * frame.row(0).transpose()).norm(), 1, 1e-3)
      << "below the horizon: on the rim";
}

TEST(ViewHemisphere, TrianglesTileTheWholeMap) {
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), upper_directions(60, 1));
  float area = 0;
  for (std::size_t t = 0; t < views.triangles.size(); ++t) area += views.area(static_cast<int>(t));
  EXPECT_NEAR(area, 4, 1e-2);
}

TEST(ViewHemisphere, NoViewLiesInsideAnothersCircumcircle) {
  // The Delaunay property itself, tested by brute force.
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), upper_directions(40, 2));
  for (const auto& [a, b, c] : views.triangles) {
    const Eigen::Vector2d pa = views.points.col(a).cast<double>(), pb = views.points.col(b).cast<double>(),
                          pc = views.points.col(c).cast<double>();
    Eigen::Matrix2d m;
    m << 2 * (pb - pa).transpose(), 2 * (pc - pa).transpose();
    if (std::abs(m.determinant()) < 1e-6) continue;
    const Eigen::Vector2d centre =
        m.inverse() * Eigen::Vector2d(pb.squaredNorm() - pa.squaredNorm(), pc.squaredNorm() - pa.squaredNorm());
    const double radius = (centre - pa).norm();
    for (Eigen::Index j = 0; j < views.points.cols(); ++j)
      EXPECT_GT((views.points.col(j).cast<double>() - centre).norm(), radius - 5e-3 * (1 + radius));
  }
}

TEST(ViewHemisphere, LocateFindsATriangleForEveryPlace) {
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), upper_directions(50, 3));
  for (float y = -0.99f; y < 1; y += 0.07f)
    for (float x = -0.99f; x < 1; x += 0.07f) {
      const ViewTriangulation::Location at = views.locate({x, y});
      ASSERT_GE(at.triangle, 0);
      Eigen::Vector2f back = Eigen::Vector2f::Zero();
      for (int c = 0; c < 3; ++c) back += at.weights[c] * views.points.col(views.triangles[at.triangle][c]);
      EXPECT_NEAR((back - Eigen::Vector2f(x, y)).norm(), 0, 1e-4);
    }
  EXPECT_EQ(views.locate({1.5f, 0}).triangle, -1);
}

TEST(ViewHemisphere, NearlyCoincidentViewsAreNoProblem) {
  Eigen::Matrix3Xf directions = upper_directions(5, 4);
  directions.conservativeResize(3, 40);
  for (int j = 5; j < 40; ++j)
    directions.col(j) = (directions.col(j % 5) + 1e-5f * Eigen::Vector3f(j % 3, j % 2, 0)).normalized();
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), directions);
  EXPECT_GE(views.locate({0.1f, 0.1f}).triangle, 0);
}

TEST(DelaunayWeights, InterpolateInsideTheHullAndClampOutside) {
  const Eigen::Matrix3Xf directions = upper_directions(30, 5);
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), directions);
  const Eigen::VectorXf at_view = delaunay_weights(views, views.points.col(4 + 7));
  EXPECT_NEAR(at_view[7], 1, 0.05);
  for (float y = -0.95f; y < 1; y += 0.19f)
    for (float x = -0.95f; x < 1; x += 0.19f) {
      const Eigen::VectorXf w = delaunay_weights(views, {x, y});
      EXPECT_NEAR(w.sum(), 1, 1e-4);
      EXPECT_GE(w.minCoeff(), 0);
    }
}

TEST(DelaunayWeights, ReproduceLinearFunctionsInsideTheHull) {
  const Eigen::Matrix3Xf directions = upper_directions(40, 6);
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), directions);
  const Eigen::Matrix2Xf places = views.points.rightCols(40);
  int inside = 0;
  for (float y = -0.95f; y < 1; y += 0.07f)
    for (float x = -0.95f; x < 1; x += 0.07f) {
      const Eigen::Vector2f place(x, y);
      const ViewTriangulation::Location at = views.locate(place);
      ASSERT_GE(at.triangle, 0);
      const auto& corners = views.triangles[static_cast<std::size_t>(at.triangle)];
      if (std::any_of(corners.begin(), corners.end(), [](int p) { return p < ViewTriangulation::kCorners; })) continue;
      ++inside;
      EXPECT_LT((places * delaunay_weights(views, place) - place).norm(), 1e-5) << x << ", " << y;
    }
  EXPECT_GT(inside, 100);
}

TEST(DelaunayWeights, NoViewsGiveNoWeights) {
  const ViewTriangulation views = triangulate_views(Eigen::Matrix3f::Identity(), Eigen::Matrix3Xf(3, 0));
  EXPECT_EQ(delaunay_weights(views, {0, 0}).size(), 0);
  EXPECT_EQ(views.triangles.size(), 2u) << "the map's four corners";
}

}  // namespace
}  // namespace sheen
