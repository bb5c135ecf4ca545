// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/sample_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

Camera camera() {
  return {.width = 400, .height = 300, .fx = 500, .fy = 500, .cx = 199.5, .cy = 149.5};
}
const Rigid3 kFromAbove = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0});

MapLayout maps_of(const Mesh& mesh, int n) {
  return MapLayout(std::vector<std::uint8_t>(mesh.triangles.size(), static_cast<std::uint8_t>(n)));
}

/// Every sample with its place in the object frame.
template <typename F>
void for_each_sample(const Mesh& mesh, const MapLayout& maps, F&& f) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int n = maps.resolution(t);
    std::size_t s = maps.first_sample(t);
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j, ++s) {
        const float u = float(i) / (n - 1), v = float(j) / (n - 1);
        f(t, s, Eigen::Vector3f((1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2)));
      }
  }
}

TEST(SampleVisibility, ASquareIsSeenButForItsRim) {
  const Mesh mesh = square_mesh(0.4f, 0, 8);
  const MapLayout maps = maps_of(mesh, 6);
  SampleVisibility visibility(mesh, maps, {});
  const SurfaceView& view = visibility.look(camera(), kFromAbove, {});
  // 250 px per metre at z = 2: the rim of 1 px is 0.004 m wide, one pixel more or less for the grid.
  for_each_sample(mesh, maps, [&](std::size_t, std::size_t s, const Eigen::Vector3f& p) {
    const float inside = 0.4f - std::max(std::abs(p.x()), std::abs(p.y()));
    if (inside > 0.017f) EXPECT_TRUE(view.visible[s]) << p.transpose();
    if (inside < 0.003f) EXPECT_FALSE(view.visible[s]) << p.transpose();
  });
}

TEST(SampleVisibility, ErosionKeepsAsManyPixelsMoreAway) {
  const Mesh mesh = square_mesh(0.4f, 0, 8);  // pixels 100 to 299, 50 to 249
  const MapLayout maps = maps_of(mesh, 6);
  for (const int erosion : {0, 1, 3}) {
    SampleVisibility visibility(mesh, maps, {.erosion_px = erosion});
    const ImageF& safe = visibility.look(camera(), kFromAbove, {}).safe_depth;
    for (int y = 0; y < 300; ++y)
      for (int x = 0; x < 400; ++x) {
        const int inside = std::min({x - 100, 299 - x, y - 50, 249 - y});
        EXPECT_NEAR(safe.at(x, y), inside >= 1 + erosion ? 2 : 0, 1e-4f) << x << ' ' << y << ' ' << erosion;
      }
  }
}

TEST(SampleVisibility, PixelsSayHowFarTheEdgeOfTheirSurfaceIs) {
  // The floor ends at pixel 299; its left part is masked to pixel 149; before it floats a square, pixels 175 to 224.
  const Mesh mesh = joined(square_mesh(0.4f, 0, 8), square_mesh(0.05f, 1, 1));
  const MapLayout maps = maps_of(mesh, 6);
  ImageU8 mask(400, 300, 1, 255);
  for (int y = 0; y < 300; ++y) std::fill_n(mask.row(y), 150, std::uint8_t{0});
  for (const int erosion : {0, 1, 4}) {
    SampleVisibility visibility(mesh, maps, {.erosion_px = erosion});
    for (int repetition = 0; repetition < 2; ++repetition) {  // the second with buffers that were used
      if (repetition == 1) visibility.look(camera(), look_at({0.3, 0.2, 1.9}, {0, 0, 0}, {0, 1, 0}), {});
      const SurfaceView& view = visibility.look(camera(), kFromAbove, mask);
      for (int y = 0; y < 300; ++y)
        for (int x = 0; x < 400; ++x) {
          const int from_middle = std::max(std::abs(2 * x - 399), std::abs(2 * y - 299)) / 2;  // 0 beside the middle
          const bool floats = from_middle <= 24;
          const int from_edge =
              floats ? 24 - from_middle : std::min({from_middle - 25, x - 150, 299 - x, y - 50, 249 - y});
          EXPECT_EQ(view.from_edge.at(x, y), std::clamp(from_edge, 0, 2)) << x << ' ' << y;
          EXPECT_NEAR(view.safe_depth.at(x, y), from_edge < 1 + erosion ? 0 : floats ? 1 : 2, 1e-4f) << x << ' ' << y;
        }
    }
  }
}

TEST(SampleVisibility, SamplesAreProjectedThroughTheLens) {
  Camera lens = camera();
  lens.distortion = {-0.2, 0.05, 0.001, -0.001, 0};
  const Mesh mesh = square_mesh(0.4f, 0, 4);
  const MapLayout maps = maps_of(mesh, 5);
  SampleVisibility visibility(mesh, maps, {});
  const SurfaceView& view = visibility.look(lens, kFromAbove, {});
  std::size_t seen = 0;
  for_each_sample(mesh, maps, [&](std::size_t t, std::size_t s, const Eigen::Vector3f& p) {
    if (!view.visible[s]) return;
    ++seen;
    const SampleProjection::Places places = view.places->of(t);
    const std::size_t i = s - maps.first_sample(t);
    const Eigen::Vector3d in_camera = kFromAbove * p.cast<double>();
    EXPECT_LT((Eigen::Vector2d(places.x[i], places.y[i]) - *lens.project(in_camera)).norm(), 1e-3);
    EXPECT_NEAR(places.z[i], in_camera.z(), 1e-6);
  });
  EXPECT_GT(seen, 100u);
}

TEST(SampleVisibility, AnOccluderHidesExactlyItsShadowSampleBySample) {
  const Mesh floor = square_mesh(0.4f, 0, 4);
  const Mesh mesh = joined(floor, square_mesh(0.1f, 1, 1));  // half way up: its shadow on the floor is 0.2 m
  const MapLayout maps = maps_of(mesh, 12);
  SampleVisibility visibility(mesh, maps, {});
  const SurfaceView& view = visibility.look(camera(), kFromAbove, {});
  int partly = 0;
  for (std::size_t t = 0; t < floor.triangles.size(); ++t)
    partly += view.visible_in_triangle[t] > 0 && view.visible_in_triangle[t] < lattice_samples(12);
  EXPECT_GT(partly, 0) << "triangles that are half hidden are decided sample by sample";
  for_each_sample(mesh, maps, [&](std::size_t t, std::size_t s, const Eigen::Vector3f& p) {
    if (t >= floor.triangles.size()) return;
    const float from_shadow = std::max(std::abs(p.x()), std::abs(p.y())) - 0.2f;
    if (from_shadow < -0.004f) EXPECT_FALSE(view.visible[s]) << p.transpose();
    if (from_shadow > 0.02f && from_shadow < 0.17f) EXPECT_TRUE(view.visible[s]) << p.transpose();
    if (from_shadow > 0 && from_shadow < 0.004f) EXPECT_FALSE(view.visible[s]) << "the depth edge is eroded";
  });
}

TEST(SampleVisibility, ASphereShowsItsFrontAndNothingGrazing) {
  const Mesh mesh = sphere_mesh(0.4f, 4);
  const MapLayout maps = maps_of(mesh, 4);
  for (const double least : {VisibilityOptions{}.min_cosine, 0.2, 0.5}) {
    SampleVisibility visibility(mesh, maps, {.min_cosine = least});
    const SurfaceView& view = visibility.look(camera(), kFromAbove, {});
    for_each_sample(mesh, maps, [&](std::size_t, std::size_t s, const Eigen::Vector3f& p) {
      const double cosine = p.normalized().dot((Eigen::Vector3f(0, 0, 2) - p).normalized());
      if (cosine > least + 0.15) EXPECT_TRUE(view.visible[s]) << cosine << " least " << least;
      if (cosine < least - 0.05) EXPECT_FALSE(view.visible[s]) << cosine << " least " << least;
    });
  }
}

TEST(SampleVisibility, BackFacesAndWhatLiesBehindThemDoNotCount) {
  Mesh turned = square_mesh(0.1f, 1, 1);
  for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
  const Mesh floor = square_mesh(0.4f, 0, 4);
  const Mesh mesh = joined(floor, turned);
  const MapLayout maps = maps_of(mesh, 6);
  SampleVisibility visibility(mesh, maps, {});
  const SurfaceView& view = visibility.look(camera(), kFromAbove, {});
  for_each_sample(mesh, maps, [&](std::size_t t, std::size_t s, const Eigen::Vector3f& p) {
    if (t >= floor.triangles.size())
      EXPECT_FALSE(view.visible[s]);
    else if (std::max(std::abs(p.x()), std::abs(p.y())) < 0.19f)
      EXPECT_FALSE(view.visible[s]);
  });
}

TEST(SampleVisibility, TheMaskIsHonouredAndEroded) {
  const Mesh mesh = square_mesh(0.4f, 0, 8);
  const MapLayout maps = maps_of(mesh, 6);
  ImageU8 mask(400, 300, 1, 255);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 200; ++x) mask.at(x, y) = 0;
  SampleVisibility visibility(mesh, maps, {});
  const SurfaceView& view = visibility.look(camera(), kFromAbove, mask);
  std::size_t seen = 0;
  for_each_sample(mesh, maps, [&](std::size_t t, std::size_t s, const Eigen::Vector3f&) {
    if (!view.visible[s]) return;
    EXPECT_GT(view.places->of(t).x[s - maps.first_sample(t)], 200.5f);
    ++seen;
  });
  EXPECT_GT(seen, 100u);
  EXPECT_EQ(seen, view.visible_samples);
}

TEST(SampleVisibility, AnObjectBehindTheCameraOrOutsideThePictureIsNotSeen) {
  const Mesh mesh = square_mesh(0.4f, 0, 2);
  const MapLayout maps = maps_of(mesh, 4);
  SampleVisibility visibility(mesh, maps, {});
  EXPECT_EQ(visibility.look(camera(), look_at({0, 0, 2}, {0, 0, 4}, {0, 1, 0}), {}).visible_samples, 0u);
  EXPECT_EQ(visibility.look(camera(), look_at({0, 0, 2}, {9, 0, 1}, {0, 1, 0}), {}).visible_samples, 0u);
  EXPECT_GT(visibility.look(camera(), kFromAbove, {}).visible_samples, 0u) << "and the next look is unharmed";
}

}  // namespace
}  // namespace sheen
