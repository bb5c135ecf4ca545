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

}  // namespace

std::string encode_webp(const ImageU8& rgb, float quality) {
  std::uint8_t* out = nullptr;
  const std::size_t bytes = rgb.channels() == 3 && !rgb.empty()
                                ? WebPEncodeRGB(rgb.data(), rgb.width(), rgb.height(), 3 * rgb.width(), quality, &out)
                                : 0;
  const std::unique_ptr<std::uint8_t, decltype(&WebPFree)> owned(out, WebPFree);
  if (bytes == 0) throw Error("a picture cannot be written as WebP");
  return {reinterpret_cast<const char*>(out), bytes};
}

ImageU8 decode_webp(std::string_view bytes) {
  int width = 0, height = 0;
  if (!WebPGetInfo(data_of(bytes), bytes.size(), &width, &height)) throw Error("is no WebP picture");
  ImageU8 rgb(width, height, 3);
  if (!WebPDecodeRGBInto(data_of(bytes), bytes.size(), rgb.data(), rgb.size(), 3 * width))
    throw Error("is a damaged WebP picture");
  return rgb;
}

}  // namespace sheen
