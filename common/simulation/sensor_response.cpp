// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/sensor_response.h"

#include <algorithm>
#include <cmath>

namespace sheen {

double SensorResponse::vignette(double x, double y) const {
  if (focal_px == 0) return 1;
  const double tangent2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (focal_px * focal_px);
  return 1 / ((1 + tangent2) * (1 + tangent2));
}

double SensorResponse::stored(double light) const {
  const double reported = std::max(0.0, black + (1 - black) * light);
  return std::min(saturation, std::pow(reported, 1 / gamma));
}

ImageF stored_values(const ImageF& radiance, double exposure, const SensorResponse& response, int levels,
                     std::uint64_t seed) {
  ImageF light = radiance;
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x)
      for (int c = 0; c < light.channels(); ++c)
        light.at(x, y, c) *= static_cast<float>(exposure * response.tint[c] * response.vignette(x, y));
  add_sensor_noise(light, response.noise, seed);
  for (std::size_t i = 0; i < light.size(); ++i)
    light.data()[i] = static_cast<float>(std::round(levels * response.stored(light.data()[i])) / levels);
  return light;
}

RawImage stored_rgb8(const ImageF& radiance, double exposure, const SensorResponse& response, std::uint64_t seed) {
  const ImageF values = stored_values(radiance, exposure, response, 255, seed);
  RawImage raw{.format = PixelFormat::kRGB8,
               .transfer = response.gamma == 1 ? Transfer::kLinear : Transfer::kSrgb,
               .width = values.width(),
               .height = values.height(),
               .stride = 3 * static_cast<std::size_t>(values.width()),
               .bytes = std::vector<std::uint8_t>(values.size())};
  for (std::size_t i = 0; i < values.size(); ++i)
    raw.bytes[i] = static_cast<std::uint8_t>(std::lround(255 * values.data()[i]));
  return raw;
}

}  // namespace sheen
