// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/vertex_ring.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

TEST(Lattice, IndicesRunThroughAllSamplesOnce) {
  for (int n = 2; n <= 20; ++n) {
    int expected = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) EXPECT_EQ(lattice_index(n, i, j), expected++);
    EXPECT_EQ(lattice_samples(n), expected);
  }
}

TEST(Lattice, StencilReproducesLinearFunctions) {
  // Linear interpolation is exact on u and v themselves, everywhere on the triangle and on its border.
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (const int n : {2, 3, 7, 16})
    for (int trial = 0; trial < 2000; ++trial) {
      float u = uniform(engine), v = uniform(engine);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      if (trial % 5 == 0) v = 1 - u;
      if (trial % 7 == 0) u = 0;
      const LatticeStencil stencil = lattice_stencil(n, u, v);
      float got_u = 0, got_v = 0, sum = 0;
      for (int k = 0; k < 3; ++k) {
        ASSERT_GE(stencil.index[k], 0);
        ASSERT_LT(stencil.index[k], lattice_samples(n));
        EXPECT_GE(stencil.weight[k], -1e-5f);
        int i = 0, j = stencil.index[k];
        while (j >= n - i) j -= n - i, ++i;
        got_u += stencil.weight[k] * i / (n - 1);
        got_v += stencil.weight[k] * j / (n - 1);
        sum += stencil.weight[k];
      }
      EXPECT_NEAR(sum, 1, 1e-5);
      EXPECT_NEAR(got_u, u, 2e-5);
      EXPECT_NEAR(got_v, std::min(v, 1 - u), 2e-5);
    }
}

TEST(VertexRings, EveryTriangleIsInTheRingsOfItsThreeCorners) {
  const Mesh mesh = sphere_mesh(1, 2);
  std::vector<std::uint8_t> resolution(mesh.triangles.size());
  for (std::size_t t = 0; t < resolution.size(); ++t) resolution[t] = static_cast<std::uint8_t>(2 + t % 5);
  const VertexRings rings(mesh, resolution);
  ASSERT_EQ(rings.size(), mesh.vertices.size());
  std::size_t members = 0;
  for (std::size_t v = 0; v < rings.size(); ++v) {
    std::uint32_t next = 0;
    for (const RingTriangle& member : rings.ring(v)) {
      EXPECT_EQ(mesh.triangles[member.triangle][member.corner], v);
      EXPECT_EQ(member.first_sample, next) << "samples of a ring are gap-free";
      EXPECT_EQ(&rings.membership(member.triangle, member.corner), &member);
      next += lattice_samples(rings.resolution(member.triangle));
      ++members;
    }
    EXPECT_EQ(rings.ring_samples(v), static_cast<int>(next));
  }
  EXPECT_EQ(members, 3 * mesh.triangles.size());
}

TEST(VertexRings, IsolatedVerticesHaveEmptyRings) {
  Mesh mesh = square_mesh(1, 0, 1);
  mesh.vertices.emplace_back(5, 5, 5);
  const VertexRings rings(mesh, std::vector<std::uint8_t>(mesh.triangles.size(), 4));
  EXPECT_TRUE(rings.ring(4).empty());
  EXPECT_EQ(rings.ring_samples(4), 0);
}

}  // namespace
}  // namespace sheen
