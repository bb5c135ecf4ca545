// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/sensor.h"

#include <algorithm>
#include <cmath>

#include "common/simulation/procedural_noise.h"

namespace sheen {
namespace {

constexpr double kWhite = 255;

/// Standard normal by Box and Muller from one hashed counter.
double normal_deviate(std::uint64_t counter) {
  const std::uint64_t first = mix_bits(counter), second = mix_bits(first);
  const double u = (double(first >> 11) + 0.5) * 0x1p-53, v = double(second >> 11) * 0x1p-53;
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
}

}  // namespace

double SensorNoise::sigma(double level) const {
  return std::sqrt(read_sigma * read_sigma + shot * std::max(0.0, level));
}

ImageF mosaic_rggb(const ImageF& radiance) {
  ImageF mosaic(radiance.width(), radiance.height(), 1);
  for (int y = 0; y < radiance.height(); ++y)
    for (int x = 0; x < radiance.width(); ++x) mosaic.at(x, y) = radiance.at(x, y, (x & 1) + (y & 1));
  return mosaic;
}

void add_sensor_noise(ImageF& mosaic, const SensorNoise& noise, std::uint64_t seed) {
  const std::uint64_t stream = mix_bits(seed);
  for (std::size_t i = 0; i < mosaic.size(); ++i) {
    float& value = mosaic.data()[i];
    value += static_cast<float>(noise.sigma(kWhite * value) / kWhite * normal_deviate(stream + i));
  }
}

RawImage quantize_rggb(const ImageF& mosaic) {
  RawImage raw{.format = PixelFormat::kBayerRG8,
               .transfer = Transfer::kLinear,
               .width = mosaic.width(),
               .height = mosaic.height(),
               .stride = static_cast<std::size_t>(mosaic.width()),
               .bytes = std::vector<std::uint8_t>(mosaic.size())};
  for (std::size_t i = 0; i < mosaic.size(); ++i)
    raw.bytes[i] = static_cast<std::uint8_t>(std::lround(std::clamp(255 * mosaic.data()[i], 0.0f, 255.0f)));
  return raw;
}

}  // namespace sheen
