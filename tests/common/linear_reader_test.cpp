// SPDX-License-Identifier: Apache-2.0
#include "common/linear_reader.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

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

// A site keeps its own value; green at a red site is Malvar, He and Cutler's filter written out.
TEST(LinearReader, DemosaicIsTheFilterOfItsAuthors) {
  const RawImage raw = noise(PixelFormat::kBayerRG8, 12, 10);
  const ImageF rgb = to_linear_rgb(raw);
  const auto at = [&](int x, int y) { return raw.bytes[y * raw.stride + x] / 255.0; };
  for (int y = 2; y < 8; ++y)
    for (int x = 2; x < 10; ++x) {
      const int own = y % 2 == 0 && x % 2 == 0 ? 0 : y % 2 == 1 && x % 2 == 1 ? 2 : 1;
      EXPECT_NEAR(rgb.at(x, y, own), at(x, y), 1e-6);
      if (own == 1) continue;
      const double green = (4 * at(x, y) + 2 * (at(x - 1, y) + at(x + 1, y) + at(x, y - 1) + at(x, y + 1)) -
                            at(x - 2, y) - at(x + 2, y) - at(x, y - 2) - at(x, y + 2)) /
                           8;
      EXPECT_NEAR(rgb.at(x, y, 1), std::max(green, 0.0), 1e-6);
    }
}

}  // namespace
}  // namespace sheen
