// SPDX-License-Identifier: Apache-2.0
#include "common/image/webp.h"

#include <webp/decode.h>
#include <webp/encode.h>

#include <algorithm>
#include <memory>

#include "common/base/errors.h"

namespace sheen {
namespace {

const std::uint8_t* data_of(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

WebPBitstreamFeatures features_of(std::string_view bytes) {
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data_of(bytes), bytes.size(), &features) != VP8_STATUS_OK)
    throw Error("is a damaged WebP picture");
  return features;
}

/// `configure`: says how.
template <typename Configure>
std::string encoded(const ImageU8& rgb, Configure configure) {
  const auto fail = [] { throw Error("a picture cannot be written as WebP"); };
  WebPConfig config;
  WebPPicture picture;
  if (rgb.channels() != 3 || rgb.empty() || !WebPConfigInit(&config) || !WebPPictureInit(&picture)) fail();
  configure(config);
  const std::unique_ptr<WebPPicture, decltype(&WebPPictureFree)> owned(&picture, WebPPictureFree);
  picture.use_argb = 1;
  picture.width = rgb.width();
  picture.height = rgb.height();
  std::string bytes;
  picture.custom_ptr = &bytes;
  picture.writer = [](const std::uint8_t* data, std::size_t size, const WebPPicture* to) {
    static_cast<std::string*>(to->custom_ptr)->append(reinterpret_cast<const char*>(data), size);
    return 1;
  };
  if (!WebPPictureImportRGB(&picture, rgb.data(), 3 * rgb.width()) || !WebPEncode(&config, &picture)) fail();
  return bytes;
}

}  // namespace

std::string encode_webp(const ImageU8& rgb, float quality) {
  return encoded(rgb, [&](WebPConfig& config) {
    config.quality = quality;
    config.use_sharp_yuv = 1;  // chroma has half the rows and columns: made so that the colours come out right
  });
}

std::string encode_webp_lossless(const ImageU8& rgb) {
  return encoded(rgb, [](WebPConfig& config) { config.lossless = 1; });
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

Cutout decode_webp_cutout(std::string_view bytes) {
  if (!features_of(bytes).has_alpha) return {decode_webp(bytes), {}};
  const auto [width, height] = decode_webp_size(bytes);
  ImageU8 rgba(width, height, 4);
  if (!WebPDecodeRGBAInto(data_of(bytes), bytes.size(), rgba.data(), rgba.size(), 4 * width))
    throw Error("is a damaged WebP picture");
  Cutout out{ImageU8(width, height, 3), ImageU8(width, height, 1)};
  for (std::size_t i = 0; i < out.alpha.size(); ++i) {
    std::copy_n(rgba.data() + 4 * i, 3, out.colours.data() + 3 * i);
    out.alpha.data()[i] = rgba.data()[4 * i + 3];
  }
  return out;
}

ImageU8 decode_webp_mask(std::string_view bytes) {
  constexpr int kLossy = 1;
  return mask_of_drawing(decode_webp_cutout(bytes), features_of(bytes).format == kLossy);
}

}  // namespace sheen
