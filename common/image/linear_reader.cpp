// SPDX-License-Identifier: Apache-2.0
#include "common/image/linear_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "common/image/color.h"
#include "common/image/demosaic.h"

namespace sheen {
namespace {

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

/// Reflects a coordinate at the borders, as often as it takes, so that the colour of the site is kept.
int mirror(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1), within = std::abs(i) % period;
  return std::min(within, period - within);
}

}  // namespace

LinearReader::LinearReader(const RawImage& image, float black_level, const float white_balance[3])
    : image_(image),
      balance_{white_balance ? white_balance[0] : 1, white_balance ? white_balance[1] : 1,
               white_balance ? white_balance[2] : 1} {
  for (int i = 0; i < 256; ++i) {
    const float v = i / 255.0f;
    const float linear = image.transfer == Transfer::kSrgb ? srgb_decode(v) : v;
    linear_[i] = std::max(0.0f, (linear - black_level) / (1 - black_level));
    if (is_bayer(image.format)) linear_[i] = root_encode(linear_[i]);
  }
}

LinearReader::LinearReader(const RawImage& image, const Photometry& photometry)
    : image_(image),
      balance_{photometry.white_balance[0], photometry.white_balance[1], photometry.white_balance[2]},
      vignette_(photometry.vignette.none() ? nullptr : &photometry.vignette) {
  for (int i = 0; i < 256; ++i)
    linear_[i] = is_bayer(image.format) ? root_encode(photometry.response[i]) : photometry.response[i];
}

void LinearReader::read(const PixelBox& box, int channels, float* out, std::size_t stride) const {
  if (is_bayer(image_.format))
    read_bayer(box, channels, out, stride);
  else
    read_pixels(box, channels, out, stride);
  if (vignette_) undo_vignette(box, channels, out, stride);
}

/// After demosaicing, which sees the noise of the sensor as it is.
void LinearReader::undo_vignette(const PixelBox& box, int channels, float* out, std::size_t stride) const {
  const ImageSize size{image_.width, image_.height};
  for (int y = box.y0; y < box.y1; ++y, out += stride)
    for (int x = box.x0; x < box.x1; ++x) {
      const auto gain = static_cast<float>(1 / vignette_->at(x, y, size));
      for (int c = 0; c < 3; ++c) out[channels * (x - box.x0) + c] *= gain;
    }
}

void LinearReader::read_pixels(const PixelBox& box, int channels, float* out, std::size_t stride) const {
  const std::size_t pixel_bytes = bytes_per_pixel(image_.format);
  for (int y = box.y0; y < box.y1; ++y, out += stride) {
    const std::uint8_t* in = image_.bytes.data() + y * image_.stride + box.x0 * pixel_bytes;
    for (int i = 0; i < box.width(); ++i, in += pixel_bytes) {
      float rgb[3];
      if (image_.format == PixelFormat::kRGB32f)
        std::memcpy(rgb, in, sizeof rgb);
      else
        for (int c = 0; c < 3; ++c) rgb[c] = linear_[in[pixel_bytes == 3 ? c : 0]];
      for (int c = 0; c < 3; ++c) out[channels * i + c] = balance_[c] * rgb[c];
      if (channels == 4) out[4 * i + 3] = 0;
    }
  }
}

void LinearReader::read_bayer(const PixelBox& box, int channels, float* out, std::size_t stride) const {
  if (box.empty()) return;
  // The cells of 2x2 sites, red first, that the box lies in.
  const auto [red_x, red_y] = red_site(image_.format);
  const int before_x = (box.x0 - red_x) & 1, before_y = (box.y0 - red_y) & 1;
  const auto even = [](int size) { return size + (size & 1); };
  const int width = even(before_x + box.width()), height = even(before_y + box.height());
  const int left = box.x0 - before_x, top = box.y0 - before_y;

  std::vector<int> column(width + 2 * kDemosaicReach);
  for (int i = 0; i < static_cast<int>(column.size()); ++i) column[i] = mirror(left - kDemosaicReach + i, image_.width);
  const auto load = [&](int y, std::span<float> sites) {
    const std::uint8_t* in = image_.bytes.data() + mirror(top + y, image_.height) * image_.stride;
    for (std::size_t i = 0; i < sites.size(); ++i) sites[i] = linear_[in[column[i]]];
  };
  const auto take = [&](int y, const float* r, const float* g, const float* b) {
    if (y < before_y || y >= before_y + box.height()) return;
    float* row = out + (y - before_y) * stride;
    const auto interleave = [&]<int kChannels>() {
      for (int i = 0; i < box.width(); ++i) {
        float* pixel = row + kChannels * i;
        pixel[0] = balance_[0] * root_decode(r[before_x + i]);
        pixel[1] = balance_[1] * root_decode(g[before_x + i]);
        pixel[2] = balance_[2] * root_decode(b[before_x + i]);
        if constexpr (kChannels == 4) pixel[3] = 0;
      }
    };
    channels == 4 ? interleave.template operator()<4>() : interleave.template operator()<3>();
  };
  demosaic(width, height, load, take);
}

ImageF to_linear_rgb(const RawImage& image, float black_level, const float white_balance[3]) {
  ImageF rgb(image.width, image.height, 3);
  LinearReader(image, black_level, white_balance)
      .read({0, 0, image.width, image.height}, 3, rgb.data(), 3 * static_cast<std::size_t>(image.width));
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
