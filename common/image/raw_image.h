// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace sheen {

/// Names of the GenICam Pixel Format Naming Convention. Values are Sheen's own and are never reused.
enum class PixelFormat : std::uint8_t {
  kUnspecified = 0,
  kMono8 = 1,
  kBayerRG8 = 2,
  kBayerGR8 = 3,
  kBayerGB8 = 4,
  kBayerBG8 = 5,
  kRGB8 = 6,
  kRGB32f = 7,  ///< little-endian float, linear radiance
};

/// How a stored value follows from light.
enum class Transfer : std::uint8_t {
  kUnspecified = 0,
  kLinear = 1,  ///< proportional to radiance, as a machine-vision camera gives it
  kSrgb = 2,    ///< sRGB-encoded, as photographs are
};

/// Pixels as a camera or a file gave them, before any interpretation. `bytes.size() == stride * height`.
struct RawImage {
  PixelFormat format = PixelFormat::kUnspecified;
  Transfer transfer = Transfer::kLinear;
  int width = 0;
  int height = 0;
  std::size_t stride = 0;  ///< bytes per row
  std::vector<std::uint8_t> bytes;

  bool operator==(const RawImage&) const = default;
};

bool is_bayer(PixelFormat format);
std::size_t bytes_per_pixel(PixelFormat format);            ///< 0 for kUnspecified
std::string_view pfnc_name(PixelFormat format);             ///< "BayerRG8", ...
PixelFormat pixel_format_from_pfnc(std::string_view name);  ///< kUnspecified when unknown

/// Empty when sizes, stride and format agree, else which field is wrong.
std::string validation_error(const RawImage& image);

}  // namespace sheen
