// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/lattice_resampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace sheen {
namespace {

/// value(u, v) at each sample.
template <typename Value>
Eigen::Matrix3Xf sampled(int n, Value value) {
  Eigen::Matrix3Xf samples(3, lattice_samples(n));
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j)
      samples.col(lattice_index(n, i, j)) =
          value(static_cast<float>(i) / static_cast<float>(n - 1), static_cast<float>(j) / static_cast<float>(n - 1));
  return samples;
}

Eigen::Vector3f linear(float u, float v) {
  return {0.2f + 0.5f * u - 0.3f * v, v, 1 - u};
}

Eigen::Matrix3Xf noise(int n) {
  std::mt19937 engine(static_cast<unsigned>(n));
  std::normal_distribution<float> normal;
  return sampled(n, [&](float, float) { return Eigen::Vector3f(normal(engine), normal(engine), normal(engine)); });
}

Eigen::Vector3f drawn(const Eigen::Matrix3Xf& values, int n, float u, float v) {
  const LatticeStencil at = lattice_stencil(n, u, v);
  return at.weight[0] * values.col(at.index[0]) + at.weight[1] * values.col(at.index[1]) +
         at.weight[2] * values.col(at.index[2]);
}

TEST(LatticeResampling, LinearFunctionsAreCarriedExactlyAndNothingOfThemIsMissed) {
  for (const int from : {2, 3, 4, 9, 24, 255})
    for (const int to : {2, 3, 5, 13, 24}) {
      const LatticeResampling resampling(from, to);
      const Eigen::Matrix3Xf values = sampled(from, linear);
      EXPECT_LT((resampling.of(values) - sampled(to, linear)).cwiseAbs().maxCoeff(), 1e-5f) << from << " to " << to;
      EXPECT_LT(resampling.missed(values).cwiseAbs().maxCoeff(), 1e-5f) << from << " to " << to;
    }
}

TEST(LatticeResampling, OnWholeMultiplesOfTheIntervalsTheSurfaceIsDrawnAsBefore) {
  const Eigen::Matrix3Xf coarse = noise(5), fine = LatticeResampling(5, 17).of(coarse);
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int trial = 0; trial < 1000; ++trial) {
    const float u = uniform(engine), v = (1 - u) * uniform(engine);
    EXPECT_LT((drawn(fine, 17, u, v) - drawn(coarse, 5, u, v)).norm(), 1e-4f) << u << ", " << v;
  }
  EXPECT_LT((LatticeResampling(17, 5).of(fine) - coarse).norm(), 1e-4f) << "and back";
}

TEST(LatticeResampling, WhatFewerSamplesMissIsWhatLiesBetweenThem) {
  // Every second sample stays, the others are one higher.
  constexpr int kFine = 9, kCoarse = 5;
  Eigen::Matrix3Xf comb = Eigen::Matrix3Xf::Ones(3, lattice_samples(kFine));
  for (int i = 0; i < kFine; i += 2)
    for (int j = 0; i + j < kFine; j += 2) comb.col(lattice_index(kFine, i, j)).setZero();
  EXPECT_EQ(LatticeResampling(kFine, kCoarse).of(comb), Eigen::Matrix3Xf::Zero(3, lattice_samples(kCoarse)));
  EXPECT_EQ(LatticeResampling(kFine, kCoarse).missed(comb), comb);
}

TEST(LatticeResampling, KnowsWhichSamplesANewOneLiesBetween) {
  const LatticeResampling halved(9, 5);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; i + j < 5; ++j)
      EXPECT_EQ(halved.nearest(lattice_index(5, i, j)), lattice_index(9, 2 * i, 2 * j)) << i << ", " << j;
  const LatticeStencil round = LatticeResampling(2, 3).round(lattice_index(3, 1, 1));  // middle of the long edge
  EXPECT_EQ(std::count(round.weight, round.weight + 3, 0.5f), 2);
}

}  // namespace
}  // namespace sheen
