// SPDX-License-Identifier: Apache-2.0
#include "common/raw_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/color.h"

namespace sheen {
namespace {

struct FormatInfo {
  PixelFormat format;
  std::string_view name;
  std::size_t bytes;
};
constexpr std::array kFormats{
    FormatInfo{PixelFormat::kMono8, "Mono8", 1},       FormatInfo{PixelFormat::kBayerRG8, "BayerRG8", 1},
    FormatInfo{PixelFormat::kBayerGR8, "BayerGR8", 1}, FormatInfo{PixelFormat::kBayerGB8, "BayerGB8", 1},
    FormatInfo{PixelFormat::kBayerBG8, "BayerBG8", 1}, FormatInfo{PixelFormat::kRGB8, "RGB8", 3},
    FormatInfo{PixelFormat::kRGB32f, "RGB32f", 12},
};

bool is_bayer(PixelFormat f) {
  return f == PixelFormat::kBayerRG8 || f == PixelFormat::kBayerGR8 || f == PixelFormat::kBayerGB8 ||
         f == PixelFormat::kBayerBG8;
}

/// Column and row of the first red site.
std::array<int, 2> red_site(PixelFormat f) {
  switch (f) {
    case PixelFormat::kBayerGR8:
      return {1, 0};
    case PixelFormat::kBayerGB8:
      return {0, 1};
    case PixelFormat::kBayerBG8:
      return {1, 1};
    default:
      return {0, 0};
  }
}

/// Reflects a coordinate at the border so that the colour of the site is kept.
int mirror(int i, int n) {
  if (i < 0) i = -i;
  if (i >= n) i = 2 * n - 2 - i;
  return std::clamp(i, 0, n - 1);
}

/// Gradient-corrected linear interpolation (Malvar, He, Cutler 2004), on values already linear.
ImageF demosaic(const ImageF& mosaic, std::array<int, 2> red) {
  const int w = mosaic.width(), h = mosaic.height();
  ImageF rgb(w, h, 3);
  for (int y = 0; y < h; ++y) {
    const float* rows[5];
    for (int k = -2; k <= 2; ++k) rows[k + 2] = mosaic.row(mirror(y + k, h));
    for (int x = 0; x < w; ++x) {
      int xs[5];
      for (int k = -2; k <= 2; ++k) xs[k + 2] = x >= 2 && x < w - 2 ? x + k : mirror(x + k, w);
      const auto at = [&](int dx, int dy) { return rows[dy + 2][xs[dx + 2]]; };
      const float c = at(0, 0);
      const float cross2 = at(-2, 0) + at(2, 0) + at(0, -2) + at(0, 2);
      const float diagonal = at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1);
      const bool red_row = ((y - red[1]) & 1) == 0, red_column = ((x - red[0]) & 1) == 0;
      float* out = rgb.pixel(x, y);
      if (red_row == red_column) {  // a red or a blue site
        const float green = (4 * c + 2 * (at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1)) - cross2) / 8;
        const float opposite = (6 * c + 2 * diagonal - 1.5f * cross2) / 8;
        out[0] = red_row ? c : opposite;
        out[1] = green;
        out[2] = red_row ? opposite : c;
      } else {
        const float along_row =
            (5 * c + 4 * (at(-1, 0) + at(1, 0)) - diagonal - at(-2, 0) - at(2, 0) + 0.5f * (at(0, -2) + at(0, 2))) / 8;
        const float along_column =
            (5 * c + 4 * (at(0, -1) + at(0, 1)) - diagonal - at(0, -2) - at(0, 2) + 0.5f * (at(-2, 0) + at(2, 0))) / 8;
        out[0] = red_row ? along_row : along_column;
        out[1] = c;
        out[2] = red_row ? along_column : along_row;
      }
      for (int k = 0; k < 3; ++k) out[k] = std::max(out[k], 0.0f);
    }
  }
  return rgb;
}

}  // namespace

std::size_t bytes_per_pixel(PixelFormat format) {
  for (const FormatInfo& f : kFormats)
    if (f.format == format) return f.bytes;
  return 0;
}

std::string_view pfnc_name(PixelFormat format) {
  for (const FormatInfo& f : kFormats)
    if (f.format == format) return f.name;
  return "unspecified";
}

PixelFormat pixel_format_from_pfnc(std::string_view name) {
  for (const FormatInfo& f : kFormats)
    if (f.name == name) return f.format;
  return PixelFormat::kUnspecified;
}

std::string validation_error(const RawImage& image) {
  const std::size_t pixel = bytes_per_pixel(image.format);
  if (pixel == 0) return "image.format is unknown";
  if (image.transfer != Transfer::kLinear && image.transfer != Transfer::kSrgb) return "image.transfer is unknown";
  if (image.width < 1 || image.width > 1 << 16) return "image.width must be 1..65536";
  if (image.height < 1 || image.height > 1 << 16) return "image.height must be 1..65536";
  if (image.stride < image.width * pixel || image.stride > std::size_t(1) << 24) return "image.stride is out of range";
  if (image.bytes.size() != image.stride * image.height) return "image.bytes does not match stride times height";
  return {};
}

ImageF to_linear_rgb(const RawImage& image, float black_level, const float white_balance[3]) {
  const int w = image.width, h = image.height;
  const std::size_t channels = image.format == PixelFormat::kRGB8 || image.format == PixelFormat::kRGB32f ? 3 : 1;
  ImageF values(w, h, static_cast<int>(channels));
  if (image.format == PixelFormat::kRGB32f) {
    for (int y = 0; y < h; ++y)
      std::memcpy(values.row(y), image.bytes.data() + y * image.stride, w * channels * sizeof(float));
  } else {
    float table[256];
    for (int i = 0; i < 256; ++i) {
      const float v = i / 255.0f;
      const float linear = image.transfer == Transfer::kSrgb ? srgb_decode(v) : v;
      table[i] = std::max(0.0f, (linear - black_level) / (1 - black_level));
    }
    for (int y = 0; y < h; ++y) {
      const std::uint8_t* in = image.bytes.data() + y * image.stride;
      float* out = values.row(y);
      for (std::size_t i = 0; i < w * channels; ++i) out[i] = table[in[i]];
    }
  }
  ImageF rgb;
  if (is_bayer(image.format)) {
    rgb = demosaic(values, red_site(image.format));
  } else if (channels == 1) {
    rgb = ImageF(w, h, 3);
    for (std::size_t i = 0; i < values.size(); ++i) std::fill_n(rgb.data() + 3 * i, 3, values.data()[i]);
  } else {
    rgb = std::move(values);
  }
  if (white_balance && (white_balance[0] != 1 || white_balance[1] != 1 || white_balance[2] != 1))
    for (std::size_t i = 0; i < rgb.size(); ++i) rgb.data()[i] *= white_balance[i % 3];
  return rgb;
}

ImageU8 to_grey8(const RawImage& image) {
  ImageU8 grey(image.width, image.height, 1);
  if (image.format == PixelFormat::kRGB32f) {
    const ImageU8 rgb = to_srgb8(to_linear_rgb(image));
    for (std::size_t i = 0; i < grey.size(); ++i)
      grey.data()[i] = (54 * rgb.data()[3 * i] + 183 * rgb.data()[3 * i + 1] + 19 * rgb.data()[3 * i + 2] + 128) >> 8;
    return grey;
  }
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* in = image.bytes.data() + y * image.stride;
    std::uint8_t* out = grey.row(y);
    if (image.format == PixelFormat::kRGB8) {
      for (int x = 0; x < image.width; ++x)
        out[x] = (54 * in[3 * x] + 183 * in[3 * x + 1] + 19 * in[3 * x + 2] + 128) >> 8;
    } else {
      std::copy_n(in, image.width, out);
    }
  }
  return grey;
}

}  // namespace sheen
