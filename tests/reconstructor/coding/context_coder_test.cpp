// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/coding/context_coder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace sheen {
namespace {

TEST(ContextCoder, BitsComeBackInTheirContexts) {
  std::mt19937 random(1);
  std::vector<std::pair<int, bool>> bits;
  for (int i = 0; i < 20000; ++i) {
    const int context = static_cast<int>(random() % 7);
    bits.emplace_back(context, random() % 100 < static_cast<unsigned>(5 + 15 * context));
  }
  ContextEncoder encoder(9);
  for (const auto& [context, bit] : bits) encoder.bit(context, bit);
  const std::string bytes = encoder.finish();
  ContextDecoder decoder(9, bytes);
  for (const auto& [context, bit] : bits) ASSERT_EQ(decoder.bit(context), bit);
}

TEST(ContextCoder, WhatIsLikelyCostsLittle) {
  std::mt19937 random(2);
  constexpr int kBits = 200000;
  ContextEncoder encoder(1);
  int ones = 0;
  for (int i = 0; i < kBits; ++i) {
    const bool one = random() % 50 == 0;
    ones += one;
    encoder.bit(0, one);
  }
  const double p = static_cast<double>(ones) / kBits;
  const double entropy_bytes = kBits / 8.0 * -(p * std::log2(p) + (1 - p) * std::log2(1 - p));
  EXPECT_LT(static_cast<double>(encoder.finish().size()), 1.06 * entropy_bytes);
}

TEST(ContextCoder, NumbersComeBackUpToTheirLimit) {
  std::vector<std::int32_t> numbers;
  for (int i = 0; i <= 40; ++i) numbers.push_back(i);
  for (int bit = 4; bit <= 23; ++bit)
    for (const int near : {-1, 0, 1}) numbers.push_back(std::min((1 << bit) + near, 1 << 23));
  ContextEncoder encoder(kSignedContexts);
  for (const std::int32_t n : numbers) {
    code_signed(encoder, 0, n);
    code_signed(encoder, 0, -n);
  }
  const std::string bytes = encoder.finish();
  ContextDecoder decoder(kSignedContexts, bytes);
  for (const std::int32_t n : numbers) {
    ASSERT_EQ(code_signed(decoder, 0, 0), n);
    ASSERT_EQ(code_signed(decoder, 0, 0), -n);
  }
}

TEST(ContextCoder, AStreamCutShortIsRefusedOrReadsAsAnything) {
  ContextEncoder encoder(3);
  for (int i = 0; i < 1000; ++i) encoder.bit(i % 3, i % 5 == 0);
  const std::string bytes = encoder.finish();
  for (std::size_t size = 0; size < bytes.size(); size += 3) {
    try {
      ContextDecoder decoder(3, std::string_view(bytes).substr(0, size));
      for (int i = 0; i < 5000; ++i) decoder.bit(i % 3);
    } catch (const std::runtime_error&) {
    }
  }
}

}  // namespace
}  // namespace sheen
