// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/map_layout.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

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

TEST(Lattice, PointsOfAllIndicesAreFound) {
  for (int n = 2; n <= 255; ++n)
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const LatticePoint found = lattice_point(n, lattice_index(n, i, j));
        ASSERT_TRUE(found.i == i && found.j == j) << n << ": " << i << ", " << j;
      }
}

TEST(Lattice, AtPointsOfAnotherLatticeTheStencilIsTheOneOfTheirPlace) {
  for (const int n : {2, 3, 7, 16, 33, 255})
    for (const int at : {2, 3, 5, 9, 31, 254, 255}) {
      const auto value = [n](int index) {  // no plane: which of a cell's two triangles is asked counts
        const LatticePoint point = lattice_point(n, index);
        return static_cast<float>((7 * point.i + 13 * point.j + 5 * point.i * point.j) % 11);
      };
      const auto drawn = [&](const LatticeStencil& stencil) {
        float sum = 0;
        for (int k = 0; k < 3; ++k) {
          EXPECT_TRUE(stencil.index[k] >= 0 && stencil.index[k] < lattice_samples(n));
          EXPECT_TRUE(stencil.weight[k] >= 0 && stencil.weight[k] <= 1);
          sum += stencil.weight[k] * value(stencil.index[k]);
        }
        return sum;
      };
      const auto last = static_cast<float>(at - 1);
      for (int i = 0; i < at; ++i)
        for (int j = 0; i + j < at; ++j) {
          const LatticeStencil of_place =
              lattice_stencil(n, static_cast<float>(i) / last, static_cast<float>(j) / last);
          ASSERT_NEAR(drawn(lattice_stencil(n, at, {i, j})), drawn(of_place), 2e-3)
              << i << ", " << j << " of " << at << " on " << n;
        }
    }
}

TEST(Lattice, APointThatBothLatticesHaveIsItselfAlone) {
  for (const int n : {3, 5, 9, 25})
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const LatticeStencil stencil = lattice_stencil(n, 2 * n - 1, {2 * i, 2 * j});
        for (int k = 0; k < 3; ++k)
          EXPECT_EQ(stencil.weight[k], stencil.index[k] == lattice_index(n, i, j) ? 1 : 0)
              << n << ": " << i << ", " << j;
      }
}

TEST(MapLayout, SamplesOfTriangleAfterTriangleLeaveNoGap) {
  const std::vector<std::uint8_t> resolution{2, 7, 3, 255, 2};
  const MapLayout maps(resolution);
  ASSERT_EQ(maps.triangles(), resolution.size());
  std::size_t next = 0;
  for (std::size_t t = 0; t < resolution.size(); ++t) {
    EXPECT_EQ(maps.resolution(t), resolution[t]);
    EXPECT_EQ(maps.first_sample(t), next);
    next += static_cast<std::size_t>(lattice_samples(resolution[t]));
  }
  EXPECT_EQ(maps.first_sample(resolution.size()), next);
  EXPECT_EQ(maps.total_samples(), next);
}

TEST(MapLayout, OfNoTriangleHasNoSample) {
  EXPECT_EQ(MapLayout({}).total_samples(), 0u);
}

}  // namespace
}  // namespace sheen
