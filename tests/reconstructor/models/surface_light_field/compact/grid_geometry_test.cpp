// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/grid_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reconstructor/coding/powers.h"
#include "reconstructor/light_field_file/encode/canonical_mesh.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

TEST(GridGeometry, RootsAreExact) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100000; ++i) {
    const auto square = static_cast<std::int64_t>(random() >> (2 + random() % 60));
    const std::int64_t root = integer_root(square);
    ASSERT_LE(root * root, square);
    ASSERT_GT((root + 1) * (root + 1), square);
  }
  for (const std::int64_t root : {0L, 1L, 94906265L, 2147483646L}) {
    EXPECT_EQ(integer_root(root * root), root);
    EXPECT_EQ(integer_root(root * root + 2 * root), root);
  }
}

TEST(GridGeometry, CosinesAreThoseOfTheMesh) {
  const CanonicalMesh mesh = canonical_mesh(sphere_mesh(0.3f, 3));
  const std::vector<Eigen::Vector3f> normals = vertex_normals(*mesh.mesh);
  const GridFacing facing(mesh.grid);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-2, 2);
  std::vector<PosedCamera> cameras(20);
  for (PosedCamera& camera : cameras)
    camera.camera_from_object.translation = {uniform(random), uniform(random), uniform(random)};
  const std::vector<GridMesh::Point> eyes = grid_eyes(cameras, mesh.grid);
  for (std::size_t v = 0; v < normals.size(); ++v)
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const Eigen::Vector3f to_eye =
          (camera_centre(cameras[c].camera_from_object).cast<float>() - mesh.mesh->vertices[v]).normalized();
      EXPECT_NEAR(static_cast<float>(facing.cosine(v, eyes[c])) / GridFacing::kOne, normals[v].dot(to_eye), 1e-3f);
      EXPECT_LT((unit_direction(mesh.grid.points[v], eyes[c]) - to_eye).norm(), 5e-5f);
    }
}

TEST(GridGeometry, ExtremesStayWithinTheirNumbers) {
  constexpr std::int32_t kEnd = 1 << 22, kFar = 1 << 30;
  const GridMesh mesh{.points = {{-kEnd, -kEnd, -kEnd}, {kEnd, kEnd, -kEnd}, {kEnd, -kEnd, kEnd}, {0, 0, 0}},
                      .triangles = std::vector<Triangle>(100000, Triangle{0, 1, 2})};
  const GridFacing facing(mesh);
  for (const GridMesh::Point& eye : {GridMesh::Point{kFar, kFar, kFar}, GridMesh::Point{-kFar, kFar, -kFar}})
    for (std::size_t v = 0; v < 4; ++v) {
      EXPECT_LE(std::abs(facing.cosine(v, eye)), GridFacing::kOne);
      EXPECT_NEAR(unit_direction(mesh.points[v], eye).norm(), 1, 1e-6f);
    }
  EXPECT_EQ(facing.cosine(3, {kFar, 0, 0}), 0) << "a vertex without a triangle faces nothing";
  EXPECT_EQ(facing.cosine(0, mesh.points[0]), 0) << "nor is there a direction to the vertex itself";
  std::vector<PosedCamera> far(1);
  far[0].camera_from_object.translation = {1e30, -1e30, 0};
  EXPECT_EQ(grid_eyes(far, mesh)[0], (GridMesh::Point{-kFar, kFar, 0}));
}

TEST(PowersOfTwo, AreThoseOfTheLibrary) {
  for (int twelfths = -1000; twelfths <= 1000; ++twelfths)
    EXPECT_NEAR(power_of_two(twelfths) / std::exp2(twelfths / 12.0), 1, 1e-13) << twelfths;
  EXPECT_EQ(power_of_two(-24), 0.25);
}

}  // namespace
}  // namespace sheen
