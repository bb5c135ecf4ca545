// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/sensor.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

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

ImageF through_lens(const ImageF& radiance, double sigma_px) {
  const int reach = std::max(1, static_cast<int>(std::ceil(4 * sigma_px)));
  std::vector<float> spot(2 * reach + 1);
  for (int k = -reach; k <= reach; ++k)
    spot[k + reach] = static_cast<float>(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
  const float total = std::accumulate(spot.begin(), spot.end(), 0.0f);
  for (float& weight : spot) weight /= total;

  const int w = radiance.width(), h = radiance.height(), channels = radiance.channels();
  const auto blur = [&](const ImageF& in, int dx, int dy) {
    ImageF out(w, h, channels);
    tbb::parallel_for(0, h, [&](int y) {
      for (int x = 0; x < w; ++x)
        for (int k = -reach; k <= reach; ++k) {
          const float* from = in.pixel(std::clamp(x + k * dx, 0, w - 1), std::clamp(y + k * dy, 0, h - 1));
          for (int c = 0; c < channels; ++c) out.at(x, y, c) += spot[k + reach] * from[c];
        }
    });
    return out;
  };
  return blur(blur(radiance, 1, 0), 0, 1);
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
