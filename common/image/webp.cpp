// SPDX-License-Identifier: Apache-2.0
#include "common/image/webp.h"

#include <webp/decode.h>
#include <webp/encode.h>

#include <memory>

#include "common/base/errors.h"

namespace sheen {
namespace {

const std::uint8_t* data_of(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

/// `encode(out)`: a call of the library that makes a picture and returns its bytes.
template <typename Encode>
std::string encoded(const ImageU8& rgb, Encode encode) {
  std::uint8_t* out = nullptr;
  const std::size_t bytes = rgb.channels() == 3 && !rgb.empty() ? encode(&out) : 0;
  const std::unique_ptr<std::uint8_t, decltype(&WebPFree)> owned(out, WebPFree);
  if (bytes == 0) throw Error("a picture cannot be written as WebP");
  return {reinterpret_cast<const char*>(out), bytes};
}

}  // namespace

std::string encode_webp(const ImageU8& rgb, float quality) {
  return encoded(rgb, [&](std::uint8_t** out) {
    return WebPEncodeRGB(rgb.data(), rgb.width(), rgb.height(), 3 * rgb.width(), quality, out);
  });
}

std::string encode_webp_lossless(const ImageU8& rgb) {
  return encoded(rgb, [&](std::uint8_t** out) {
    return WebPEncodeLosslessRGB(rgb.data(), rgb.width(), rgb.height(), 3 * rgb.width(), out);
  });
}

ImageSize decode_webp_size(std::string_view bytes) {
  ImageSize size{};
  if (!WebPGetInfo(data_of(bytes), bytes.size(), &size.width, &size.height)) throw Error("is a damaged WebP picture");
  // A picture of one colour packs without end; a header that claims more must not be given the memory.
  constexpr double kHarmless = 1 << 24, kMostPerByte = 10'000;  // pixels
  const double claimed = double(size.width) * size.height;
  if (claimed > kHarmless + kMostPerByte * double(bytes.size()))
    throw Error("claims " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                " pixels, more than the file can hold");
  return size;
}

ImageU8 decode_webp(std::string_view bytes) {
  const auto [width, height] = decode_webp_size(bytes);
  ImageU8 rgb(width, height, 3);
  if (!WebPDecodeRGBInto(data_of(bytes), bytes.size(), rgb.data(), rgb.size(), 3 * width))
    throw Error("is a damaged WebP picture");
  return rgb;
}

}  // namespace sheen
