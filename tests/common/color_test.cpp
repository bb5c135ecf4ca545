// SPDX-License-Identifier: Apache-2.0
#include "common/color.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

TEST(Srgb, KnowsItsFixedPointsAndInverts) {
  EXPECT_FLOAT_EQ(srgb_encode(0), 0);
  EXPECT_NEAR(srgb_encode(1), 1, 1e-6);
  EXPECT_NEAR(srgb_encode(0.21404114f), 0.5f, 1e-6) << "IEC 61966-2-1: mid grey";
  for (float x = 0; x < 30; x = x * 1.1f + 1e-3f)
    EXPECT_NEAR(srgb_decode(srgb_encode(x)), x, 2e-5f * (1 + std::abs(x)));
}

TEST(Srgb, TheTableAgreesWithTheFunction) {
  for (float x = 1e-6f; x < 64; x *= 1.0007f) {
    const float exact = srgb_encode(x);
    EXPECT_NEAR(srgb_encode_fast(x), exact, 2e-5f * std::max(1.0f, exact)) << x;
  }
  EXPECT_FLOAT_EQ(srgb_encode_fast(-0.5f), srgb_encode(-0.5f));
}

TEST(Srgb, EightBitsSurviveTheRoundTrip) {
  ImageU8 all(256, 1, 1);
  for (int i = 0; i < 256; ++i) all.at(i, 0) = static_cast<std::uint8_t>(i);
  EXPECT_EQ(to_srgb8(from_srgb8(all)), all);
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
