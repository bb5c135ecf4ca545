// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/patch_quantising.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>

#include "reconstructor/light_field_file/encode/band_rounding.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {
namespace {

TEST(BandRounding, WithoutAPriceForBitsItIsTheNearest) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0, 3);
  BandRounding rounding(0);
  for (int i = 0; i < 50; ++i) {
    Eigen::VectorXf exact(40);
    for (float& x : exact) x = normal(random);
    std::vector<std::int32_t> rounded = rounding.rounded(exact, i % 3);
    rounded.resize(40);
    for (int f = 0; f < 40; ++f) {
      const float error = std::abs(exact[f] - rounded_value(rounded[static_cast<std::size_t>(f)]));
      for (const int other : {-1, 1})
        EXPECT_LE(error, std::abs(exact[f] - rounded_value(rounded[static_cast<std::size_t>(f)] + other)));
    }
  }
}

TEST(BandRounding, ALoneValueIsWorthLessThanOneAmongOthers) {
  Eigen::VectorXf lone = Eigen::VectorXf::Zero(12), among = Eigen::VectorXf::Constant(12, -2.1f);
  lone[6] = among[6] = 0.9f;
  EXPECT_TRUE(BandRounding(0.12f).rounded(lone, 0).empty());
  const std::vector<std::int32_t> kept = BandRounding(0.12f).rounded(among, 0);
  ASSERT_EQ(kept.size(), 12u);
  EXPECT_EQ(kept[6], 1);
  EXPECT_EQ(kept[5], -2);
  lone[6] = 1.9f;
  EXPECT_EQ(BandRounding(0.12f).rounded(lone, 0), (std::vector<std::int32_t>{0, 0, 0, 0, 0, 0, 2}));
}

TEST(BandRounding, WhatIsFarOutOfRangeStaysInIt) {
  const Eigen::VectorXf exact = Eigen::VectorXf::Constant(3, -1e20f);
  for (const std::int32_t value : BandRounding(0.12f).rounded(exact, 1)) EXPECT_LE(std::abs(value), (1 << 22) + 1);
}

struct Exact {
  std::vector<int> resolutions;
  Patch patch;
  ViewHaar::Plan plan;
  Eigen::MatrixXf pictures() const { return patch.basis.unpacked() * patch.coefficients; }
};

/// Terms that fall off, over a few images.
Exact exact_patch(Eigen::Index images, std::vector<int> resolutions = {7, 5, 9}) {
  Exact exact{.resolutions = std::move(resolutions)};
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  Eigen::Index rows = 0;
  for (const int resolution : exact.resolutions) rows += 3 * lattice_samples(resolution);
  constexpr Eigen::Index kTerms = 4;
  Eigen::MatrixXf basis(rows, kTerms);
  exact.patch.coefficients.resize(kTerms, images);
  exact.patch.displayed.resize(kTerms);
  for (Eigen::Index k = 0; k < kTerms; ++k) {
    for (Eigen::Index i = 0; i < rows; ++i)
      basis(i, k) = std::sin(0.02f * static_cast<float>((k + 1) * i)) + 0.3f * normal(random);
    basis.col(k).normalize();
    const float size = 12 / static_cast<float>(k + 1);
    for (Eigen::Index j = 0; j < images; ++j)
      exact.patch.coefficients(k, j) = size * std::sqrt(static_cast<float>(rows)) * normal(random);
    exact.patch.displayed[k] = size;
  }
  exact.patch.basis = PackedColumns<float>(basis);
  exact.patch.mean = Eigen::VectorXf::LinSpaced(rows, 20, 180);
  std::vector<GridMesh::Point> eyes(static_cast<std::size_t>(images));
  std::vector<std::uint16_t> all;
  for (GridMesh::Point& eye : eyes) {
    for (std::int32_t& entry : eye) entry = static_cast<std::int32_t>(1e5f * normal(random));
    all.push_back(static_cast<std::uint16_t>(all.size()));
  }
  exact.plan = ViewHaar(eyes, {0, 0, 0}).plan(all);
  return exact;
}

double rms(const Eigen::MatrixXf& difference) {
  return std::sqrt(difference.squaredNorm() / static_cast<float>(difference.size()));
}

TEST(PatchSpectrum, ErrorsAreAboutAsLargeAsTheStepAllows) {
  for (const Eigen::Index images : {4, 60}) {
    const Exact exact = exact_patch(images);
    for (const float step : {0.05f, 0.5f, 3.0f}) {
      const Patch patch = dequantise(quantise(exact.patch, exact.resolutions, exact.plan, step, {}), exact.resolutions,
                                     exact.plan, step);
      // Uniform rounding errs by step / sqrt(12); the dead zone by up to some three times that, in each of four terms.
      EXPECT_LT(rms(patch.mean - exact.patch.mean), step) << step;
      EXPECT_LT(rms(patch.basis.unpacked() * patch.coefficients - exact.pictures()), 2 * step) << step;
    }
  }
}

TEST(PatchSpectrum, CoefficientsMakeUpForWhatTheMapsLost) {
  // They are those of least squares, as far as their own rounding lets them: half a step of theirs, which is the finer,
  // the more rows stand by it.
  const Exact exact = exact_patch(2, {40, 40, 40, 40, 40, 40});
  constexpr float kStep = 8;
  const Patch patch =
      dequantise(quantise(exact.patch, exact.resolutions, exact.plan, kStep, {}), exact.resolutions, exact.plan, kStep);
  const Eigen::MatrixXf basis = patch.basis.unpacked(), best = basis.colPivHouseholderQr().solve(exact.pictures()),
                        lost = exact.pictures() - basis * patch.coefficients, least = exact.pictures() - basis * best;
  ASSERT_GE(basis.cols(), 2);
  EXPECT_LT(rms(lost), 1.0006 * rms(least));
}

TEST(PatchSpectrum, APatchOfNothingKnownIsOne) {
  const Exact exact = exact_patch(3);
  EXPECT_FALSE(quantise(Patch{}, exact.resolutions, exact.plan, 1, {}).known);
  EXPECT_EQ(dequantise(QuantisedPatch{}, exact.resolutions, exact.plan, 1).mean.size(), 0);
}

}  // namespace
}  // namespace sheen
