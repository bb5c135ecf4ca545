// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/context_coder.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "reconstructor/coding/difference_coding.h"

namespace sheen {
namespace {

double entropy(double p) {
  return -(p * std::log2(p) + (1 - p) * std::log2(1 - p));
}

TEST(ContextCoder, BitsComeBackInTheirContexts) {
  std::mt19937 random(1);
  std::vector<std::pair<int, bool>> bits;
  for (int i = 0; i < 20000; ++i) {
    const int context = static_cast<int>(random() % 7);
    bits.emplace_back(context, random() % 100 < static_cast<unsigned>(5 + 15 * context));
  }
  BitModel learned(9);
  ContextEncoder encoder(learned);
  for (const auto& [context, bit] : bits) encoder.bit(context, bit);
  const std::string bytes = encoder.finish();
  BitModel read(9);
  ContextDecoder decoder(read, bytes);
  for (const auto& [context, bit] : bits) ASSERT_EQ(decoder.bit(context), bit);
}

TEST(ContextCoder, WhatIsLikelyCostsLittle) {
  std::mt19937 random(2);
  constexpr int kBits = 200000;
  BitModel learned(1);
  ContextEncoder encoder(learned);
  int ones = 0;
  for (int i = 0; i < kBits; ++i) {
    const bool one = random() % 50 == 0;
    ones += one;
    encoder.bit(0, one);
  }
  EXPECT_LT(static_cast<double>(encoder.finish().size()),
            1.06 * kBits / 8 * entropy(static_cast<double>(ones) / kBits));
}

TEST(ContextCoder, ContextsThatAreSeldomUsedCostLittle) {
  // An estimator that learns as well as any (Krichevsky and Trofimov) pays half the logarithm of the number of bits,
  // and one bit more, for not knowing how likely a one is.
  constexpr int kUses = 24, kSeldom = 2000;
  std::mt19937 random(3);
  BitModel learned(kSeldom);
  ContextEncoder encoder(learned);
  double most = 0;
  for (int context = 0; context < kSeldom; ++context) {
    const unsigned percent = context % 2 == 0 ? 4 : 85;
    most += kUses * entropy(percent / 100.0) + std::log2(kUses) / 2 + 1;
    for (int i = 0; i < kUses; ++i) encoder.bit(context, random() % 100 < percent);
  }
  EXPECT_LT(static_cast<double>(encoder.finish().size()), most / 8);
}

TEST(ContextCoder, AMixtureIsAboutAsGoodAsItsBestContext) {
  std::mt19937 random(4);
  constexpr int kBits = 100000;
  // Contexts 0 and 1 tell what to expect, 2 and 3 tell nothing.
  BitModel learned(4, 1);
  ContextEncoder encoder(learned);
  std::vector<std::pair<std::array<int, 2>, bool>> bits;
  for (int i = 0; i < kBits; ++i) {
    const int tells = static_cast<int>(random() % 2), other = static_cast<int>(random() % 2);
    bits.push_back({{tells, 2 + other}, random() % 100 < (tells == 0 ? 3u : 90u)});
  }
  for (const auto& [contexts, bit] : bits) encoder.bit(contexts, 0, bit);
  const std::string bytes = encoder.finish();
  EXPECT_LT(8.0 * static_cast<double>(bytes.size()) / kBits, 1.05 * (entropy(0.03) + entropy(0.9)) / 2);

  BitModel read(4, 1);
  ContextDecoder decoder(read, bytes);
  for (const auto& [contexts, bit] : bits) ASSERT_EQ(decoder.bit(contexts, 0), bit);
}

TEST(ContextCoder, WhatWasLearnedServesTheNextStream) {
  std::mt19937 random(5);
  BitModel written(50), read(50);
  std::size_t before = 0;
  for (int stream = 0; stream < 2; ++stream) {
    ContextEncoder encoder(written);
    std::vector<bool> bits;
    for (int i = 0; i < 2000; ++i) bits.push_back(encoder.bit(i % 50, random() % 20 == 0));
    const std::string bytes = encoder.finish();
    if (stream > 0) {
      EXPECT_LT(bytes.size(), 0.95 * static_cast<double>(before));
    }
    before = bytes.size();
    ContextDecoder decoder(read, bytes);
    for (int i = 0; i < 2000; ++i) ASSERT_EQ(decoder.bit(i % 50), bits[static_cast<std::size_t>(i)]);
  }
}

TEST(ContextCoder, EveryMachineExpectsTheSame) {
  // What the model expects was written down once. A file that one machine wrote is read by any other only while this
  // holds; a change needs a new version of the formats.
  BitModel learned(6, 2);
  std::uint32_t random = 12345, sum = 0;
  for (int i = 0; i < 20000; ++i) {
    random = 1664525 * random + 1013904223;
    const int a = static_cast<int>(random >> 29) % 3, b = 3 + static_cast<int>(random >> 25) % 3;
    const std::array<int, 2> contexts = {a, b};
    const std::size_t count = i % 4 == 0 ? 1 : 2;
    sum = 31 * sum + learned.zeros_of_256(std::span(contexts).first(count), i % 2);
    learned.learn((random >> 8) % 100 < static_cast<std::uint32_t>(3 + 30 * a + (b == 4 ? 25 : 0)));
  }
  EXPECT_EQ(sum, 3585184758u);
}

TEST(ContextCoder, NumbersComeBackUpToTheirLimit) {
  std::vector<std::int32_t> numbers;
  for (int i = 0; i <= 40; ++i) numbers.push_back(i);
  for (int bit = 4; bit <= 23; ++bit)
    for (const int near : {-1, 0, 1}) numbers.push_back(std::min((1 << bit) + near, 1 << 23));
  BitModel learned(kSignedContexts);
  ContextEncoder encoder(learned);
  for (const std::int32_t n : numbers) {
    code_signed(encoder, 0, n);
    code_signed(encoder, 0, -n);
  }
  const std::string bytes = encoder.finish();
  BitModel read(kSignedContexts);
  ContextDecoder decoder(read, bytes);
  for (const std::int32_t n : numbers) {
    ASSERT_EQ(code_signed(decoder, 0, 0), n);
    ASSERT_EQ(code_signed(decoder, 0, 0), -n);
  }
}

TEST(DifferenceCoding, NumbersComeBackAndNoneIsOutOfRange) {
  const std::vector<std::int8_t> numbers = {0, 0, 3, -6, 6, 6, 5, 0, -32, 32};
  const std::string bytes = encode_differences(numbers);
  EXPECT_EQ(decode_differences<std::int8_t>(bytes, numbers.size(), -32, 32), numbers);
  EXPECT_THROW(decode_differences<std::int8_t>(bytes, numbers.size(), -32, 31), std::runtime_error);
  EXPECT_THROW(decode_differences<std::int8_t>(bytes, numbers.size(), -31, 32), std::runtime_error);
  EXPECT_THROW(decode_differences<std::int8_t>({}, numbers.size(), -32, 32), std::runtime_error);
}

TEST(ContextCoder, AStreamCutShortIsRefusedOrReadsAsAnything) {
  BitModel learned(3);
  ContextEncoder encoder(learned);
  for (int i = 0; i < 1000; ++i) encoder.bit(i % 3, i % 5 == 0);
  const std::string bytes = encoder.finish();
  for (std::size_t size = 0; size < bytes.size(); size += 3) {
    try {
      BitModel read(3);
      ContextDecoder decoder(read, std::string_view(bytes).substr(0, size));
      for (int i = 0; i < 5000; ++i) decoder.bit(i % 3);
    } catch (const std::runtime_error&) {
    }
  }
}

}  // namespace
}  // namespace sheen
