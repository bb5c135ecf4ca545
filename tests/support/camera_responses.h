// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>

#include "common/image/color.h"

namespace sheen {

/// 0 up to a black level (of full scale), then in proportion to the light that a value stands for, up to 1.
inline std::array<float, 256> response_above(double black_level, double (*light_of)(double value)) {
  std::array<float, 256> response{};
  for (int value = 0; value < 256; ++value)
    response[value] =
        static_cast<float>(std::clamp((light_of(value / 255.0) - black_level) / (1 - black_level), 0.0, 1.0));
  return response;
}

/// Its values are proportional to light above the black level.
inline std::array<float, 256> linear_response(double black_level) {
  return response_above(black_level, [](double value) { return value; });
}

/// They are sRGB-encoded light.
inline std::array<float, 256> srgb_response(double black_level) {
  return response_above(black_level, [](double value) { return double{srgb_decode(static_cast<float>(value))}; });
}

}  // namespace sheen
