// SPDX-License-Identifier: Apache-2.0
#include "common/image/raw_image.h"
#include "common/image/image.h"
#include "common/image/linear_reader.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sheen {
namespace {

constexpr PixelFormat kBayer[] = {PixelFormat::kBayerRG8, PixelFormat::kBayerGR8, PixelFormat::kBayerGB8,
                                  PixelFormat::kBayerBG8};

/// The mosaic of a colour image that varies linearly in x and y.
RawImage mosaic_of_gradient(PixelFormat format, int w, int h) {
  RawImage raw{.format = format, .width = w, .height = h, .stride = std::size_t(w)};
  raw.bytes.resize(raw.stride * h);
  const int red_x = format == PixelFormat::kBayerGR8 || format == PixelFormat::kBayerBG8;
  const int red_y = format == PixelFormat::kBayerGB8 || format == PixelFormat::kBayerBG8;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const bool rx = (x & 1) == red_x, ry = (y & 1) == red_y;
      const int base = rx && ry ? 120 : (!rx && !ry ? 40 : 80);
      raw.bytes[y * w + x] = static_cast<std::uint8_t>(base + 2 * x + y);
    }
  return raw;
}

// Exact on encoded values (`Demosaic.AffinePlanesAreReturnedExactly`); what the root bends over a pixel stays.
TEST(RawImage, AMosaicOfAGradientIsTheGradientInEveryOrderOfColours) {
  constexpr double kEighthOfAGreyLevel = 0.125 / 255;
  for (const PixelFormat format : kBayer) {
    const ImageF rgb = to_linear_rgb(mosaic_of_gradient(format, 16, 12));
    for (int y = 2; y < 10; ++y)
      for (int x = 2; x < 14; ++x) {
        const float slope = (2 * x + y) / 255.0f;
        EXPECT_NEAR(rgb.at(x, y, 0), 120 / 255.0f + slope, kEighthOfAGreyLevel)
            << pfnc_name(format) << ' ' << x << ' ' << y;
        EXPECT_NEAR(rgb.at(x, y, 1), 80 / 255.0f + slope, kEighthOfAGreyLevel);
        EXPECT_NEAR(rgb.at(x, y, 2), 40 / 255.0f + slope, kEighthOfAGreyLevel);
      }
  }
}

TEST(RawImage, BlackLevelAndWhiteBalanceAreApplied) {
  RawImage raw{.format = PixelFormat::kRGB8, .width = 1, .height = 1, .stride = 3, .bytes = {51, 102, 255}};
  const float balance[3] = {2, 1, 0.5f};
  const ImageF rgb = to_linear_rgb(raw, 0.2f, balance);
  EXPECT_NEAR(rgb.at(0, 0, 0), 0, 1e-6);
  EXPECT_NEAR(rgb.at(0, 0, 1), 0.25f, 1e-6);
  EXPECT_NEAR(rgb.at(0, 0, 2), 0.5f, 1e-6);
}

TEST(RawImage, ValidationNamesTheField) {
  RawImage raw{
      .format = PixelFormat::kMono8, .width = 4, .height = 2, .stride = 4, .bytes = std::vector<std::uint8_t>(8)};
  EXPECT_EQ(validation_error(raw), "");
  raw.bytes.pop_back();
  EXPECT_NE(validation_error(raw).find("bytes"), std::string::npos);
  raw.stride = 3;
  EXPECT_NE(validation_error(raw).find("stride"), std::string::npos);
  raw.format = static_cast<PixelFormat>(99);
  EXPECT_NE(validation_error(raw).find("format"), std::string::npos);
}

TEST(RawImage, PfncNamesRoundTrip) {
  for (int i = 1; i <= 7; ++i) {
    const auto format = static_cast<PixelFormat>(i);
    EXPECT_EQ(pixel_format_from_pfnc(pfnc_name(format)), format);
    EXPECT_GT(bytes_per_pixel(format), 0u);
  }
  EXPECT_EQ(pixel_format_from_pfnc("YUV422Packed"), PixelFormat::kUnspecified);
}

}  // namespace
}  // namespace sheen
