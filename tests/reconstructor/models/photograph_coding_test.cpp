// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/photograph_coding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/base/errors.h"
#include "common/image/webp.h"
#include "tests/support/test_meshes.h"

namespace sheen {
namespace {

constexpr int kSide = 96, kObjectFrom = 24, kObjectTo = 72;

/// A textured square that a photograph shows in its middle; round it is what `background` says.
template <typename Background>
Photograph photograph(Background background) {
  Photograph p{.pixels = ImageU8(kSide, kSide, 3), .depth = ImageF(kSide, kSide, 1)};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const bool object = x >= kObjectFrom && x < kObjectTo && y >= kObjectFrom && y < kObjectTo;
      const bool read = x >= kObjectFrom - 2 && x < kObjectTo + 2 && y >= kObjectFrom - 2 && y < kObjectTo + 2;
      p.depth.at(x, y) = object ? 1.0f : 0.0f;
      for (int c = 0; c < 3; ++c)
        p.pixels.at(x, y, c) =
            read ? static_cast<std::uint8_t>(127 + 60 * std::sin(0.4 * x + c) * std::cos(0.3 * y)) : background();
    }
  return p;
}

PhotographSet set_of(std::vector<Photograph> photographs) {
  return {PhotographSet(std::make_shared<Mesh>(square_mesh(0.1f, 0, 2)), VisibilityOptions{}), std::move(photographs)};
}

double mean_square_error(const PhotographSet& a, const PhotographSet& b) {
  double sum = 0;
  for (int y = kObjectFrom; y < kObjectTo; ++y)
    for (int x = kObjectFrom; x < kObjectTo; ++x)
      for (int c = 0; c < 3; ++c)
        sum += std::pow(a.photographs()[0].pixels.at(x, y, c) - b.photographs()[0].pixels.at(x, y, c), 2);
  return sum;
}

TEST(PhotographCoding, WhatIsNotOfTheObjectCostsNothing) {
  std::mt19937 random(1);
  const PhotographSet plain = set_of({photograph([] { return std::uint8_t{0}; })}),
                      noisy = set_of({photograph([&] { return static_cast<std::uint8_t>(random()); })});
  const CodedPhotographs a = code_photographs(plain, 2000), b = code_photographs(noisy, 2000);
  EXPECT_EQ(a.bytes, b.bytes);
  EXPECT_EQ(a.photographs->photographs()[0].pixels, b.photographs->photographs()[0].pixels);
}

TEST(PhotographCoding, KeepsToItsBytesAndIsBetterInMore) {
  const PhotographSet photographs = set_of({photograph([] { return std::uint8_t{90}; })});
  double before = INFINITY;
  for (const std::size_t bytes : {400, 800, 1600}) {
    const CodedPhotographs coded = code_photographs(photographs, bytes);
    EXPECT_LE(coded.bytes, bytes);
    EXPECT_GT(coded.bytes, bytes / 2);
    const double error = mean_square_error(photographs, *coded.photographs);
    EXPECT_LT(error, before) << bytes;
    before = error;
  }
  EXPECT_GT(code_photographs(photographs, 1).bytes, 1u) << "the worst quality, and the truth about its size";
}

TEST(Webp, RefusesWhatIsNone) {
  const std::string whole = encode_webp(photograph([] { return std::uint8_t{0}; }).pixels, 80);
  EXPECT_EQ(decode_webp(whole).width(), kSide);
  EXPECT_THROW(decode_webp(""), Error);
  EXPECT_THROW(decode_webp("RIFF none of it"), Error);
  EXPECT_THROW(decode_webp(std::string_view(whole).substr(0, whole.size() / 2)), Error);
  EXPECT_THROW(encode_webp({}, 80), Error);
}

}  // namespace
}  // namespace sheen
