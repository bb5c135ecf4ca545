// SPDX-License-Identifier: Apache-2.0
#include "common/image/color.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sheen {
namespace {

TEST(Srgb, KnowsItsFixedPointsAndInverts) {
  EXPECT_FLOAT_EQ(srgb_encode(0), 0);
  EXPECT_NEAR(srgb_encode(1), 1, 1e-6);
  EXPECT_NEAR(srgb_encode(0.21404114f), 0.5f, 1e-6) << "IEC 61966-2-1: mid grey";
  for (float x = 0; x < 30; x = x * 1.1f + 1e-3f)
    EXPECT_NEAR(srgb_decode(srgb_encode(x)), x, 2e-5f * (1 + std::abs(x)));
}

TEST(Srgb, TheFastEncodingAgreesWithTheExactOneAndManyAtOnceWithOneByOne) {
  std::vector<float> values{0, -0.5f, 0.0031308f, 1};
  for (float x = 1e-30f; x < 1e30f; x *= 1.0027f) values.push_back(x);
  std::vector<float> encoded = values;
  srgb_encode_fast(std::span<float>(encoded));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float exact = srgb_encode(values[i]);
    EXPECT_NEAR(encoded[i], exact, 2e-6f * std::max(0.1f, std::abs(exact))) << values[i];
    EXPECT_FLOAT_EQ(srgb_encode_fast(values[i]), encoded[i]);
  }
  EXPECT_TRUE(std::isnan(srgb_encode_fast(std::nanf(""))));
}

TEST(Srgb, EightBitsSurviveTheRoundTrip) {
  ImageF light(256, 1, 1);
  for (int i = 0; i < 256; ++i) light.at(i, 0) = srgb_decode(static_cast<float>(i) / 255);
  const ImageU8 encoded = to_srgb8(light);
  for (int i = 0; i < 256; ++i) EXPECT_EQ(encoded.at(i, 0), i);
}

TEST(Srgb, NanBecomesBlackAndTooBrightBecomesWhite) {
  ImageF odd(3, 1, 1);
  odd.at(0, 0) = std::nanf("");
  odd.at(1, 0) = 1e9f;
  odd.at(2, 0) = -1;
  const ImageU8 out = to_srgb8(odd);
  EXPECT_EQ(out.at(0, 0), 0);
  EXPECT_EQ(out.at(1, 0), 255);
  EXPECT_EQ(out.at(2, 0), 0);
}

}  // namespace
}  // namespace sheen
