// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "common/image/image.h"

namespace sheen {

/// sRGB transfer function (IEC 61966-2-1), continued above 1 by its power law and below 0 by its linear part, so that
/// high dynamic range survives. Linear radiance -> encoded value.
float srgb_encode(float linear);

/// Inverse of `srgb_encode`.
float srgb_decode(float encoded);

/// `srgb_encode` by polynomials: to 2e-6 of the value, several times as fast; many values at once are vectorised.
float srgb_encode_fast(float linear);
void srgb_encode_fast(std::span<float> values);

/// Linear RGB (1 or 3 channels) -> 8-bit sRGB: clamped and rounded. NaN becomes 0.
ImageU8 to_srgb8(const ImageF& linear);
void to_srgb8(std::span<const float> linear, std::uint8_t* codes);  ///< value by value

/// Rec. 709 luminance of a linear RGB triple.
inline float luminance(const float* rgb) {
  return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

}  // namespace sheen
