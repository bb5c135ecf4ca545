// SPDX-License-Identifier: Apache-2.0
#include "common/simulation/sensor.h"
#include "common/image/linear_reader.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

TEST(Sensor, NoiseHasTheVarianceOfItsModel) {
  const SensorNoise noise;
  for (const double level : {0.0, 40.0, 128.0, 230.0}) {
    ImageF flat(400, 300, 1, float(level / 255));
    add_sensor_noise(flat, noise, 7);
    double sum = 0, squares = 0, cubes = 0;
    for (std::size_t i = 0; i < flat.size(); ++i) {
      const double e = 255.0 * flat.data()[i] - level;
      sum += e, squares += e * e, cubes += e * e * e;
    }
    const double n = double(flat.size());
    const double variance = noise.read_sigma * noise.read_sigma + noise.shot * level, sigma = std::sqrt(variance);
    EXPECT_LE(sigma, 2.0);
    EXPECT_NEAR(sum / n, 0, 4 * sigma / std::sqrt(n));
    EXPECT_NEAR(squares / n / variance, 1, 4 * std::sqrt(2 / n));
    EXPECT_NEAR(cubes / n / (variance * sigma), 0, 4 * std::sqrt(15 / n)) << "not lopsided";
  }
}

TEST(Sensor, NeighboursAndFramesAreIndependent) {
  ImageF a(300, 300, 1, 0.5f), b = a;
  add_sensor_noise(a, {}, 1);
  add_sensor_noise(b, {}, 2);
  double self = 0, neighbour = 0, frames = 0;
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x + 1 < 300; ++x) {
      const double e = a.at(x, y) - 0.5;
      self += e * e;
      neighbour += e * (a.at(x + 1, y) - 0.5);
      frames += e * (b.at(x, y) - 0.5);
    }
  EXPECT_LT(std::abs(neighbour / self), 0.015);
  EXPECT_LT(std::abs(frames / self), 0.015);
}

TEST(Sensor, TheSameSeedGivesTheSameNoise) {
  ImageF a(32, 16, 1, 0.3f), b = a;
  add_sensor_noise(a, {}, 5);
  add_sensor_noise(b, {}, 5);
  EXPECT_EQ(a, b);
}

TEST(Sensor, TheMosaicIsRggbAndDevelopsBack) {
  ImageF flat(16, 12, 3);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < 3; ++c) flat.at(x, y, c) = 0.2f * float(c + 1);
  const RawImage raw = quantize_rggb(mosaic_rggb(flat));
  EXPECT_EQ(validation_error(raw), "");
  EXPECT_EQ(raw.format, PixelFormat::kBayerRG8);
  EXPECT_EQ(raw.bytes[0], 51);
  EXPECT_EQ(raw.bytes[1], 102);
  EXPECT_EQ(raw.bytes[16], 102);
  EXPECT_EQ(raw.bytes[17], 153);
  const ImageF back = to_linear_rgb(raw);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(back.at(7, 6, c), 0.2 * (c + 1), 1e-6);
}

TEST(Sensor, ClipsAndRounds) {
  ImageF mosaic(2, 2, 1);
  mosaic.at(0, 0) = -0.5f, mosaic.at(1, 0) = 1.7f, mosaic.at(0, 1) = 100.4f / 255, mosaic.at(1, 1) = 100.6f / 255;
  const RawImage raw = quantize_rggb(mosaic);
  EXPECT_EQ(raw.bytes, (std::vector<std::uint8_t>{0, 255, 100, 101}));
}

TEST(Lens, ThrowsAGaussianSpotThatKeepsTheLight) {
  ImageF point(31, 31, 1);
  point.at(15, 15) = 1;
  const ImageF spot = through_lens(point, 0.7);
  double sum = 0, second = 0;
  for (int y = 0; y < 31; ++y)
    for (int x = 0; x < 31; ++x) {
      sum += spot.at(x, y);
      second += spot.at(x, y) * (x - 15) * (x - 15);
    }
  EXPECT_NEAR(sum, 1, 1e-5);
  EXPECT_NEAR(second, 0.7 * 0.7, 0.01);
  const ImageF flat(9, 7, 3, 0.25f);
  const ImageF same = through_lens(flat, 0.7);
  for (std::size_t i = 0; i < same.size(); ++i) EXPECT_NEAR(same.data()[i], 0.25f, 1e-6) << "borders included";
}

}  // namespace
}  // namespace sheen
