// SPDX-License-Identifier: Apache-2.0
#include "common/linear_reader.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "common/color.h"

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

/// Reflects a coordinate at the border so that the colour of the site is kept.
int mirror(int i, int n) {
  if (i < 0) i = -i;
  if (i >= n) i = 2 * n - 2 - i;
  return std::clamp(i, 0, n - 1);
}

/// Gradient-corrected linear interpolation (Malvar, He, Cutler 2004) of one row of `n` sites. `rows[2]` is the row,
/// rows[0..4] reach from two above to two below, each readable from -2 to n + 1. A row has green sites and sites of one
/// other colour, "own": those where (i + phase) is even. `opposite` is the third colour.
void interpolate_row(const float* const rows[5], int n, int phase, float* __restrict own, float* __restrict green,
                     float* __restrict opposite) {
  const float *up2 = rows[0], *up = rows[1], *row = rows[2], *down = rows[3], *down2 = rows[4];
  for (int i = 0; i < n; ++i) {
    const float c = row[i];
    const float beside = row[i - 1] + row[i + 1], beside2 = row[i - 2] + row[i + 2];
    const float above = up[i] + down[i], above2 = up2[i] + down2[i];
    const float diagonal = up[i - 1] + up[i + 1] + down[i - 1] + down[i + 1];
    const float cross2 = beside2 + above2;
    const float green_here = (4 * c + 2 * (beside + above) - cross2) / 8;
    const float opposite_here = (6 * c + 2 * diagonal - 1.5f * cross2) / 8;
    const float along_row = (5 * c + 4 * beside - diagonal - beside2 + 0.5f * above2) / 8;
    const float along_column = (5 * c + 4 * above - diagonal - above2 + 0.5f * beside2) / 8;
    const bool own_site = ((i + phase) & 1) == 0;
    own[i] = std::max(own_site ? c : along_row, 0.0f);
    green[i] = std::max(own_site ? green_here : c, 0.0f);
    opposite[i] = std::max(own_site ? opposite_here : along_column, 0.0f);
  }
}

template <int kChannels>
void interleave(const float* r, const float* g, const float* b, const float balance[3], int n, float* __restrict out) {
  const float br = balance[0], bg = balance[1], bb = balance[2];
  for (int i = 0; i < n; ++i) {
    out[kChannels * i] = br * r[i];
    out[kChannels * i + 1] = bg * g[i];
    out[kChannels * i + 2] = bb * b[i];
    if constexpr (kChannels == 4) out[kChannels * i + 3] = 0;
  }
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
  }
}

void LinearReader::read(const PixelBox& box, int channels, float* out, std::size_t stride) const {
  if (is_bayer(image_.format)) return read_bayer(box, channels, out, stride);
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
  const auto [red_x, red_y] = red_site(image_.format);
  const int n = box.width();
  const std::size_t length = n + 4;
  std::vector<float> linear(5 * length), planes(3 * static_cast<std::size_t>(n));
  const auto load = [&](int y) {  // the row, two more pixels at both ends, into its place among five
    const std::uint8_t* in = image_.bytes.data() + mirror(y, image_.height) * image_.stride;
    float* row = linear.data() + (y + 5) % 5 * length;
    for (int i = 0; i < n + 4; ++i) {
      const int x = box.x0 - 2 + i;
      row[i] = linear_[in[i < 2 || i >= n + 2 ? mirror(x, image_.width) : x]];
    }
  };
  for (int y = box.y0 - 2; y < box.y0 + 2; ++y) load(y);
  for (int y = box.y0; y < box.y1; ++y, out += stride) {
    load(y + 2);
    const float* rows[5];
    for (int k = -2; k <= 2; ++k) rows[k + 2] = linear.data() + (y + k + 5) % 5 * length + 2;
    const bool red_row = ((y - red_y) & 1) == 0;
    const int phase = (box.x0 - red_x + (red_row ? 0 : 1)) & 1;
    float *first = planes.data(), *green = first + n, *third = green + n;
    interpolate_row(rows, n, phase, red_row ? first : third, green, red_row ? third : first);
    if (channels == 4)
      interleave<4>(first, green, third, balance_, n, out);
    else
      interleave<3>(first, green, third, balance_, n, out);
  }
}

}  // namespace sheen
