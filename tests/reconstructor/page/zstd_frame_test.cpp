// SPDX-License-Identifier: Apache-2.0
// The page's decompressor against zstd's own compressor.
#include "reconstructor/page/wasm/zstd_frame.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <functional>
#include <random>
#include <string>

namespace sheen {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string packed(const std::string& text, int level) {
  std::string out(ZSTD_compressBound(text.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), level));
  return out;
}

/// What compresses well, badly and not at all: each kind is coded in other ways.
std::vector<std::string> texts(std::mt19937& random) {
  const std::function<std::string()> parts[] = {
      [&] { return std::string(1, static_cast<char>(random())); },
      [&] { return std::string(1, static_cast<char>('a' + random() % 4)); },
      [&] { return std::string(1, static_cast<char>(random() % 16 * (random() % 16))); },
      [&] { return "\"rotation\": [0." + std::to_string(random()) + ", " + std::to_string(random() % 100) + "], "; },
      [] { return std::string("x"); }};
  std::vector<std::string> texts;
  for (const auto& part : parts)
    for (const std::size_t size : {0, 1, 5, 100, 1000, 70'000, 300'000}) {
      std::string text;
      while (text.size() < size) text += part();
      texts.push_back(text);
    }
  return texts;
}

TEST(ZstdFrame, UnpacksWhatZstdPacks) {
  std::mt19937 random(1);
  for (const std::string& text : texts(random))
    for (const int level : {-5, 1, 3, 9, 19}) {
      const std::string frame = packed(text, level);
      EXPECT_EQ(zstd_content_size(bytes_of(frame)), text.size());
      std::string out(text.size(), '\0');
      EXPECT_TRUE(unpack_zstd(bytes_of(frame), {reinterpret_cast<std::uint8_t*>(out.data()), out.size()}));
      EXPECT_TRUE(out == text) << text.size() << " bytes at level " << level;
    }
}

TEST(ZstdFrame, DamagedFramesAreRefusedOrGiveOtherBytesAndEnd) {
  std::mt19937 random(2);
  for (const std::string& text : texts(random)) {
    if (text.size() > 1000) continue;
    const std::string frame = packed(text, 19);
    std::string out(text.size(), '\0');
    const std::span<std::uint8_t> room(reinterpret_cast<std::uint8_t*>(out.data()), out.size());
    for (std::size_t cut = 0; cut < frame.size(); ++cut)
      EXPECT_FALSE(unpack_zstd(bytes_of(frame.substr(0, cut)), room));
    for (int i = 0; i < 200; ++i) {
      std::string damaged = frame;
      damaged[random() % damaged.size()] ^= static_cast<char>(1 << random() % 8);
      unpack_zstd(bytes_of(damaged), room);
    }
  }
}

}  // namespace
}  // namespace sheen
