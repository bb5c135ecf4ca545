// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>

#include "common/image/color.h"

namespace sheen {

/// That of a camera whose values above a black level (of full scale) are proportional to light.
inline std::array<float, 256> linear_response(double black_level) {
  std::array<float, 256> response{};
  for (int value = 0; value < 256; ++value)
    response[value] = static_cast<float>(std::clamp((value / 255.0 - black_level) / (1 - black_level), 0.0, 1.0));
  return response;
}

/// And where they are sRGB-encoded light.
inline std::array<float, 256> srgb_response(double black_level) {
  std::array<float, 256> response{};
  for (int value = 0; value < 256; ++value) {
    const double light = srgb_decode(static_cast<float>(value / 255.0));
    response[value] = static_cast<float>(std::clamp((light - black_level) / (1 - black_level), 0.0, 1.0));
  }
  return response;
}

}  // namespace sheen
