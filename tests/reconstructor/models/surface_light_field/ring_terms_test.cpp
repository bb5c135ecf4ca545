// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "reconstructor/models/surface_light_field/ring_model.h"
#include "tests/support/test_matrices.h"

namespace sheen {
namespace {

constexpr int kSamples = 60, kImages = 64;
constexpr float kGreyLevel = 1.0f / 255;

/// Over the upper half of the sphere, evenly.
Eigen::Vector3f direction_of(int image) {
  const float turn = 2.399963f * static_cast<float>(image), z = 0.3f + 0.7f * static_cast<float>(image + 1) / kImages;
  return Eigen::Vector3f(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z).normalized();
}

/// A ring of grey 0.5 with independent noise, and a second term that follows the direction.
RingModel ring_of(float noise, float second, RingModelOptions options) {
  options.factor.tolerance = 0;  // what the noise makes of it by itself
  options.repeat_angle = 0;
  RingModel ring(kSamples, options);
  const Eigen::VectorXf pattern = gaussian_matrix(3 * kSamples, 1, 1);
  const std::vector<std::uint8_t> visible(kSamples, 1);
  for (int image = 0; image < kImages; ++image) {
    const Eigen::Vector3f direction = direction_of(image);
    const Eigen::VectorXf column = Eigen::VectorXf::Constant(3 * kSamples, 0.5f) + second * direction.x() * pattern +
                                   noise * gaussian_matrix(3 * kSamples, 1, 100u + static_cast<unsigned>(image));
    if (!ring.absorb({shared_rows(column)}, visible, direction, 1, 1).wants_interpolation) continue;
    ring.set_interpolation({{0.6f, 1.0f}, false});  // which smooths
    ring.choose_terms(Eigen::Vector3f::UnitZ());
  }
  ring.fold_pending();
  return ring;
}

/// Terms of half a grey level or more.
RingModelOptions what_shows() {
  RingModelOptions options;
  options.least_displayed = 0.5f * kGreyLevel;
  return options;
}

TEST(RingTerms, NoiseCostsNoneButTheReserve) {
  EXPECT_GE(ring_of(2 * kGreyLevel, 0, {}).rank(), 20) << "with all terms";
  // What smoothing over some ten views leaves of two grey levels of noise is spread over as many terms.
  const RingModel ring = ring_of(2 * kGreyLevel, 0, what_shows());
  EXPECT_LE(ring.rank(), 3);
  EXPECT_LE(ring.factor().rank(), 7);
}

TEST(RingTerms, WhatShowsIsKept) {
  const RingModel ring = ring_of(2 * kGreyLevel, 8 * kGreyLevel, what_shows());
  EXPECT_GE(ring.rank(), 2);
  EXPECT_LE(ring.rank(), 4);
  // The second term is in the leading ones: the pattern lies in what they span.
  const Eigen::MatrixXf basis = ring.factor().displayed_basis();
  const Eigen::VectorXf pattern = gaussian_matrix(3 * kSamples, 1, 1);
  EXPECT_LT((pattern - basis * (basis.transpose() * pattern)).norm(), 0.2f * pattern.norm());
}

TEST(RingTerms, ARingOfOneColourHasOneTerm) {
  const RingModel ring = ring_of(0, 0, what_shows());
  EXPECT_EQ(ring.rank(), 1);
}

}  // namespace
}  // namespace sheen
