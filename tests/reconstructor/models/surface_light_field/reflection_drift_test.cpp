// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/reflection_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace sheen {
namespace {

Eigen::Vector3f mirrored(const Eigen::Vector3f& d, const Eigen::Vector3f& n) {
  return 2 * n.dot(d) * n - d;
}

/// A broad lamp to one side: a polynomial of degree 4, which the harmonics hold exactly.
float light(const Eigen::Vector3f& r) {
  const float c = r.dot(Eigen::Vector3f(0.6f, 0, 0.8f));
  return c * c * c * c;
}

/// Patches of all normals and greys in front of 12 eyes each.
std::vector<PatchLevels> patches(int count, bool shiny, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto draw = [&] { return Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized(); };
  std::vector<PatchLevels> out;
  for (int v = 0; v < count; ++v) {
    PatchLevels patch{draw(), Eigen::Matrix3Xf(3, 12), Eigen::Matrix3Xf(3, 12), Eigen::VectorXf::Ones(12)};
    const float grey = 0.2f + 0.4f * static_cast<float>(v % 7) / 6;
    for (int j = 0; j < 12; ++j) {
      Eigen::Vector3f d = draw();
      if (d.dot(patch.normal) < 0) d = -d;
      patch.directions.col(j) = d;
      patch.levels.col(j).setConstant(grey * (1 + (shiny ? 0.5f * light(mirrored(d, patch.normal)) : 0)));
    }
    out.push_back(patch);
  }
  return out;
}

TEST(ReflectionDrift, FindsTheLightThatAllPatchesMirror) {
  const auto drift = estimate_reflection_drift(patches(300, true, 1));
  ASSERT_TRUE(drift);
  // Known up to a factor and a constant: what is left of the true light after the best of both.
  for (const PatchLevels& patch : patches(20, true, 2)) {
    Eigen::VectorXd truth(12), found(12);
    for (int j = 0; j < 12; ++j) {
      truth[j] = light(mirrored(patch.directions.col(j), patch.normal));
      found[j] = drift->at(patch.directions.col(j), patch.normal);
    }
    truth.array() -= truth.mean();
    found.array() -= found.mean();
    const double left = (truth - truth.dot(found) / found.squaredNorm() * found).squaredNorm() / truth.squaredNorm();
    EXPECT_LT(left, 0.01);
  }
}

TEST(ReflectionDrift, ARoundAtATimeGivesTheSameBitsAsAllAtOnce) {
  const std::vector<PatchLevels> some = patches(300, true, 1);
  ReflectionFit fit(some);
  int rounds = 1;
  while (!fit.step()) ++rounds;
  EXPECT_GT(rounds, 1);
  EXPECT_TRUE(fit.step()) << "nothing is left to do";
  EXPECT_EQ(fit.result()->coefficients, estimate_reflection_drift(some)->coefficients);
}

TEST(ReflectionDrift, AMatteObjectAndFewPatchesHaveNone) {
  EXPECT_FALSE(estimate_reflection_drift(patches(5, true, 3)));
  const auto drift = estimate_reflection_drift(patches(300, false, 4));
  if (drift) EXPECT_LT(drift->coefficients.tail(kHarmonics - 1).norm(), 1e-3);
}

TEST(ReflectionDrift, OneImputedLevelThatRanAwayDoesNotBendIt) {
  std::vector<PatchLevels> some = patches(300, true, 1);
  const auto clean = estimate_reflection_drift(some);
  some[7].levels.col(3).setConstant(1e4f);
  some[7].reliability[3] = 0.05f;
  const auto bent = estimate_reflection_drift(some);
  EXPECT_LT((bent->coefficients - clean->coefficients).tail(kHarmonics - 1).norm(),
            0.05f * clean->coefficients.tail(kHarmonics - 1).norm());
}

}  // namespace
}  // namespace sheen
