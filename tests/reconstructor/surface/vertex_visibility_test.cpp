// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "reconstructor/surface/sample_visibility.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

constexpr VisibilityOptions kByVertices{.test = VisibilityTest::kVertices};
const Rigid3 kFromAbove = look_at({0, 0, 2}, {0, 0, 0}, {0, 1, 0});

/// 250 pixels per metre of the plane z = 0 seen from above, 500 of z = 1.
Camera camera() {
  return {.width = 400, .height = 300, .fx = 500, .fy = 500, .cx = 199.5, .cy = 149.5};
}

/// A triangle of the plane z = 0 that faces up.
Mesh floor_triangle() {
  Mesh mesh;
  mesh.vertices = {{-0.3f, -0.2f, 0}, {0.3f, -0.2f, 0}, {0, 0.3f, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

/// A small square half way up, whose shadow from the eye on the floor is centred there, with sides of twice 0.06 m.
Mesh square_over(float x, float y) {
  Mesh square = square_mesh(0.03f, 1, 1);
  for (Eigen::Vector3f& vertex : square.vertices) vertex += Eigen::Vector3f(x / 2, y / 2, 0);
  return square;
}

MapLayout maps_of(const Mesh& mesh) {
  constexpr std::uint8_t kSide = 12;
  return MapLayout(std::vector(mesh.triangles.size(), kSide));
}

/// How many samples of the floor the image shows.
int shown(const Mesh& mesh, const VisibilityOptions& options, const ImageU8& mask = {}, const Camera& from = camera()) {
  const MapLayout maps = maps_of(mesh);
  return SampleVisibility(mesh, maps, options).look(from, kFromAbove, mask).visible_in_triangle[0];
}

TEST(VertexVisibility, ATriangleIsShownWhereItsThreeVerticesAre) {
  const int all = lattice_samples(12);
  EXPECT_EQ(shown(floor_triangle(), kByVertices), all);
  EXPECT_LT(shown(floor_triangle(), {}), all) << "samples at the rim touch an edge";
}

TEST(VertexVisibility, OneHiddenVertexHidesTheTriangle) {
  for (const Eigen::Vector3f& vertex : floor_triangle().vertices) {
    const Mesh mesh = joined(floor_triangle(), square_over(vertex.x(), vertex.y()));
    EXPECT_EQ(shown(mesh, kByVertices), 0) << vertex.transpose();
    EXPECT_GT(shown(mesh, {}), lattice_samples(12) / 2) << "most of its samples are seen";
  }
}

TEST(VertexVisibility, WhatHidesTheMiddleAloneHidesNothing) {
  const Mesh mesh = joined(floor_triangle(), square_over(0, -0.05f));
  EXPECT_EQ(shown(mesh, kByVertices), lattice_samples(12));
}

TEST(VertexVisibility, AVertexOutsideTheImageOrMaskedIsNotSeen) {
  Camera narrow = camera();
  narrow.width = 270;  // the vertex at x = 0.3 is at pixel 274.5
  EXPECT_EQ(shown(floor_triangle(), kByVertices, {}, narrow), 0);
  EXPECT_GT(shown(floor_triangle(), {}, {}, narrow), 0);
  ImageU8 mask(400, 300, 1, 255);
  for (int y = 0; y < 90; ++y) std::fill_n(mask.row(y), 400, std::uint8_t{0});  // the vertex at y = 0.3: row 74.5
  EXPECT_EQ(shown(floor_triangle(), kByVertices, mask), 0);
}

TEST(VertexVisibility, AMaskedPixelInTheMiddleShowsNothing) {
  ImageU8 mask(400, 300, 1, 255);
  for (int y = 140; y < 170; ++y) std::fill_n(mask.row(y) + 180, 40, std::uint8_t{0});
  int expected = 0;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; i + j < 12; ++j) {
      const double u = i / 11.0, v = j / 11.0;
      const double x = -0.3 + 0.6 * u + 0.3 * v, y = -0.2 + 0.5 * v;
      const int column = static_cast<int>(std::lround(199.5 + 250 * x)),
                row = static_cast<int>(std::lround(149.5 - 250 * y));
      expected += !(column >= 180 && column < 220 && row >= 140 && row < 170);
    }
  EXPECT_LT(expected, lattice_samples(12));
  EXPECT_EQ(shown(floor_triangle(), kByVertices, mask), expected);
}

TEST(VertexVisibility, TheBackOfATriangleIsNotSeen) {
  Mesh mesh = floor_triangle();
  std::swap(mesh.triangles[0][1], mesh.triangles[0][2]);
  EXPECT_EQ(shown(mesh, kByVertices), 0);
}

}  // namespace
}  // namespace sheen
