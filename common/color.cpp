// SPDX-License-Identifier: Apache-2.0
#include "common/color.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace sheen {
namespace {

// The table's knots are the floats with the top kMantissaBits of the mantissa, over exponents 2^-9 .. 2^4; below, the
// transfer function is linear and needs no table; above, it is left to pow.
constexpr int kMantissaBits = 6;
constexpr int kShift = 23 - kMantissaBits;
constexpr std::uint32_t kFirst = std::bit_cast<std::uint32_t>(0x1p-9f) >> kShift;
constexpr std::uint32_t kLast = std::bit_cast<std::uint32_t>(0x1p4f) >> kShift;

const std::vector<std::array<float, 2>>& encode_table() {
  static const std::vector<std::array<float, 2>> table = [] {
    std::vector<std::array<float, 2>> t(kLast - kFirst + 1);
    for (std::uint32_t i = 0; i < t.size(); ++i) {
      const float x0 = std::bit_cast<float>((kFirst + i) << kShift);
      const float x1 = std::bit_cast<float>((kFirst + i + 1) << kShift);
      const float y0 = srgb_encode(x0), y1 = srgb_encode(x1);
      t[i] = {y0, (y1 - y0) / (x1 - x0)};
    }
    return t;
  }();
  return table;
}

}  // namespace

float srgb_encode(float x) {
  if (!(x > 0.0031308f)) return 12.92f * x;
  return 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
}

float srgb_decode(float y) {
  if (!(y > 0.04045f)) return y / 12.92f;
  return std::pow((y + 0.055f) / 1.055f, 2.4f);
}

float srgb_encode_fast(float x) {
  if (!(x > 0.0031308f)) return 12.92f * x;
  if (x >= 0x1p4f) return srgb_encode(x);
  static const std::array<float, 2>* table = encode_table().data();
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(x) >> kShift;
  const auto& [y0, slope] = table[bits - kFirst];
  return y0 + slope * (x - std::bit_cast<float>(bits << kShift));
}

ImageU8 to_srgb8(const ImageF& linear) {
  ImageU8 out(linear.width(), linear.height(), linear.channels());
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const float v = srgb_encode_fast(linear.data()[i]);
    out.data()[i] = v > 0 ? static_cast<std::uint8_t>(std::min(v, 1.0f) * 255.0f + 0.5f) : 0;  // NaN fails the test
  }
  return out;
}

ImageF from_srgb8(const ImageU8& encoded) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t;
    for (int i = 0; i < 256; ++i) t[i] = srgb_decode(i / 255.0f);
    return t;
  }();
  ImageF out(encoded.width(), encoded.height(), encoded.channels());
  for (std::size_t i = 0; i < encoded.size(); ++i) out.data()[i] = table[encoded.data()[i]];
  return out;
}

}  // namespace sheen
