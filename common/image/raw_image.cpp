// SPDX-License-Identifier: Apache-2.0
#include "common/image/raw_image.h"

#include <array>

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

}  // namespace

bool is_bayer(PixelFormat f) {
  return f == PixelFormat::kBayerRG8 || f == PixelFormat::kBayerGR8 || f == PixelFormat::kBayerGB8 ||
         f == PixelFormat::kBayerBG8;
}

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

}  // namespace sheen
