// SPDX-License-Identifier: Apache-2.0
#include "common/image/linear_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include "tests/support/camera_responses.h"

namespace sheen {
namespace {

RawImage noise(PixelFormat format, int width, int height) {
  const std::size_t stride = width * bytes_per_pixel(format) + 3;
  RawImage raw{.format = format, .width = width, .height = height, .stride = stride};
  raw.bytes.resize(stride * height);
  std::mt19937 engine(5);
  for (std::uint8_t& byte : raw.bytes) byte = static_cast<std::uint8_t>(engine());
  if (format == PixelFormat::kRGB32f)
    for (int y = 0; y < height; ++y)
      for (int i = 0; i < 3 * width; ++i) {
        const float value = 0.01f * static_cast<float>(engine() % 100);
        std::memcpy(&raw.bytes[y * stride + 4 * i], &value, 4);
      }
  return raw;
}

TEST(LinearReader, ABoxIsWhatTheWholeImageHasThere) {
  const float balance[3] = {1.5f, 1, 0.8f};
  for (const PixelFormat format :
       {PixelFormat::kMono8, PixelFormat::kBayerRG8, PixelFormat::kBayerGR8, PixelFormat::kBayerGB8,
        PixelFormat::kBayerBG8, PixelFormat::kRGB8, PixelFormat::kRGB32f}) {
    const RawImage raw = noise(format, 13, 11);
    const ImageF whole = to_linear_rgb(raw, 0.1f, balance);
    const LinearReader reader(raw, 0.1f, balance);
    for (const PixelBox& box : {PixelBox{0, 0, 13, 11}, PixelBox{0, 0, 1, 1}, PixelBox{12, 10, 13, 11},
                                PixelBox{3, 4, 10, 9}, PixelBox{1, 0, 12, 11}, PixelBox{5, 5, 5, 7}}) {
      const std::size_t stride = 4 * box.width() + 1;
      std::vector<float> out(stride * box.height() + 1, -1);
      reader.read(box, 4, out.data(), stride);
      for (int y = box.y0; y < box.y1; ++y)
        for (int x = box.x0; x < box.x1; ++x) {
          const float* pixel = &out[(y - box.y0) * stride + 4 * (x - box.x0)];
          for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], whole.at(x, y, c), 1e-6) << pfnc_name(format);
          EXPECT_EQ(pixel[3], 0);
        }
    }
  }
}

TEST(LinearReader, ASiteOfAMosaicKeepsItsOwnValue) {
  for (const PixelFormat format :
       {PixelFormat::kBayerRG8, PixelFormat::kBayerGR8, PixelFormat::kBayerGB8, PixelFormat::kBayerBG8}) {
    const RawImage raw = noise(format, 13, 11);
    const ImageF rgb = to_linear_rgb(raw);
    const int red_x = format == PixelFormat::kBayerGR8 || format == PixelFormat::kBayerBG8;
    const int red_y = format == PixelFormat::kBayerGB8 || format == PixelFormat::kBayerBG8;
    for (int y = 0; y < 11; ++y)
      for (int x = 0; x < 13; ++x) {
        const int own = (x + red_x) % 2 + (y + red_y) % 2;
        EXPECT_NEAR(rgb.at(x, y, own), raw.bytes[y * raw.stride + x] / 255.0, 1e-6) << pfnc_name(format);
      }
  }
}

TEST(LinearReader, UndoesWhatTheCameraMadeOfLight) {
  constexpr int kWidth = 24, kHeight = 18;
  Photometry photometry{linear_response(0.1), {10, 7, {-0.4, 0.1, -0.02}}, {2, 1, 0.5f}, 1};
  const auto vignette = [&](int x, int y) {  // written out again
    const double r2 = ((x - 10.0) * (x - 10) + (y - 7.0) * (y - 7)) / ((24.0 * 24 + 18 * 18) / 4);
    return 1 - 0.4 * r2 + 0.1 * r2 * r2 - 0.02 * r2 * r2 * r2;
  };
  RawImage raw = noise(PixelFormat::kRGB8, kWidth, kHeight);
  for (const Transfer transfer :
       {Transfer::kLinear, Transfer::kSrgb}) {  // what the camera says of itself counts no more
    raw.transfer = transfer;
    ImageF rgb(kWidth, kHeight, 3);
    LinearReader(raw, photometry).read({0, 0, kWidth, kHeight}, 3, rgb.data(), 3 * kWidth);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        for (int c = 0; c < 3; ++c) {
          const double stored = raw.bytes[y * raw.stride + 3 * x + c] / 255.0;
          const double truth = std::max(0.0, (stored - 0.1) / 0.9) / vignette(x, y) * photometry.white_balance[c];
          EXPECT_NEAR(rgb.at(x, y, c), truth, 1e-5);
        }
  }
  // Demosaicing works on what the sensor saw: a site keeps its own value, and the vignette is undone after it.
  const RawImage mosaic = noise(PixelFormat::kBayerGB8, kWidth, kHeight);
  ImageF with(kWidth, kHeight, 3), box(7, 5, 4);
  LinearReader(mosaic, photometry).read({0, 0, kWidth, kHeight}, 3, with.data(), 3 * kWidth);
  LinearReader(mosaic, photometry).read({9, 3, 16, 8}, 4, box.data(), 4 * 7);
  const float balance[3] = {2, 1, 0.5f};
  const ImageF without = to_linear_rgb(mosaic, 0.1f, balance);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(with.at(x, y, c), without.at(x, y, c) / vignette(x, y), 1e-5);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(box.at(2, 3, c), with.at(11, 6, c), 1e-5);
}

// Smaller than what demosaicing looks at: the picture is mirrored as often as it takes, each site's colour with it.
TEST(LinearReader, AFlatMosaicIsFlatHoweverSmall) {
  for (const int size : {1, 2, 3, 5, 8}) {
    RawImage raw{.format = PixelFormat::kBayerRG8, .width = size, .height = size, .stride = std::size_t(size)};
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) raw.bytes.push_back(static_cast<std::uint8_t>(60 * (x % 2 + y % 2 + 1)));
    const ImageF rgb = to_linear_rgb(raw);
    if (size == 1) {  // one colour is all that there is
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb.at(0, 0, c), 60 / 255.0, 1e-6);
      continue;
    }
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb.at(x, y, c), 60 * (c + 1) / 255.0, 1e-6) << size;
  }
}

}  // namespace
}  // namespace sheen
