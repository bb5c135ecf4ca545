// SPDX-License-Identifier: Apache-2.0
#include "common/image/color.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace sheen {
namespace {

/// x^(5/12) of a normal float > 0, to 1e-6 of its value: 2^(5/12 log2 x) by polynomials (interpolation at Chebyshev
/// nodes), without a branch, so that loops over it are vectorised. (The library of emscripten has no std::bit_cast.)
inline float power_5_12(float x) {
  const auto bits = __builtin_bit_cast(std::int32_t, x);
  const auto exponent = static_cast<float>((bits >> 23) - 127);
  const float z = __builtin_bit_cast(float, (bits & 0x7fffff) | 0x3f800000) - 1;  // mantissa - 1, in [0, 1)
  const float log2 =
      ((((((0.02001665f * z - 0.09462681f) * z + 0.21394321f) * z - 0.3383772f) * z + 0.47749636f) * z - 0.7211441f) *
           z +
       1.442693f) *
      z;
  // 5/12 in two parts, of which the first times an exponent is exact: far from 1, the digits behind the point count.
  constexpr float kCoarse = 213.0f / 512, kRest = static_cast<float>(5.0 / 12 - 213.0 / 512);
  const float coarse = kCoarse * exponent, fine = kRest * exponent + (5.0f / 12) * log2;
  const auto whole = static_cast<std::int32_t>(coarse + fine + 128) - 128;  // floor: it is above -128
  const float part = (coarse - static_cast<float>(whole)) + fine;
  const float exp2 =
      ((((0.001893754f * part + 0.00894959f) * part + 0.05586034f) * part + 0.24014182f) * part + 0.6931545f) * part +
      0.9999999f;
  return exp2 * __builtin_bit_cast(float, (whole + 127) << 23);
}

inline float encode(float x) {
  const float curve = 1.055f * power_5_12(x) - 0.055f;  // of a number that is not above the threshold: not used
  return x > 0.0031308f ? curve : 12.92f * x;
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
  return encode(x);
}

void srgb_encode_fast(std::span<float> values) {
  float* v = values.data();
  for (std::size_t i = 0; i < values.size(); ++i) v[i] = encode(v[i]);
}

void to_srgb8(std::span<const float> linear, std::uint8_t* codes) {
  const float* const values = linear.data();
  for (std::size_t i = 0; i < linear.size(); ++i) {  // without a branch: vectorised
    const float encoded = encode(values[i]);
    const float positive = encoded > 0 ? encoded : 0;  // NaN fails the test
    codes[i] = static_cast<std::uint8_t>(static_cast<std::int32_t>(std::min(positive, 1.0f) * 255.0f + 0.5f));
  }
}

ImageU8 to_srgb8(const ImageF& linear) {
  ImageU8 out(linear.width(), linear.height(), linear.channels());
  to_srgb8({linear.data(), linear.size()}, out.data());
  return out;
}

}  // namespace sheen
