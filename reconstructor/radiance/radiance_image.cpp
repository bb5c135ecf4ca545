// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/radiance_image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/capture/linear_capture.h"
#include "reconstructor/surface/edge_fill.h"

namespace sheen {
namespace {

constexpr int kBlock = 8;    // pixels of the full image that a pixel of the coarsest level covers
constexpr int kStrip = 128;  // rows that are decoded at once: demosaicing looks at rows beyond them again
// Up to this distance between samples the full image is read: the cubic kernel itself passes little beyond it.
constexpr float kFullResolutionStep = 1.6f;
constexpr float kCubicA = -0.6f;
// Channel that is 1 where two pixels round lies nothing but the pixel's own surface, at most as `fill_edges` leaves it.
constexpr int kClear = 3;

using Pixel = Eigen::Array4f;

Pixel texel(const ImageF& image, int x, int y) {
  return Eigen::Map<const Pixel>(
      image.pixel(std::clamp(x, 0, image.width() - 1), std::clamp(y, 0, image.height() - 1)));
}

/// Coefficients of the four weights of cubic convolution as polynomials of the fraction t, highest power first; each
/// weight stands `repeat` times.
template <int repeat>
struct CubicPolynomials {
  std::array<Eigen::Array<float, 4 * repeat, 1>, 4> coefficients;

  CubicPolynomials() {
    constexpr float a = kCubicA;
    constexpr float terms[4][4] = {
        {a, a + 2, -(a + 2), -a}, {-2 * a, -(a + 3), 2 * a + 3, a}, {a, 0, -a, 0}, {0, 1, 0, 0}};
    for (int power = 0; power < 4; ++power)
      for (int i = 0; i < 4 * repeat; ++i) coefficients[power][i] = terms[power][i / repeat];
  }
  Eigen::Array<float, 4 * repeat, 1> weights(float t) const {
    return ((coefficients[0] * t + coefficients[1]) * t + coefficients[2]) * t + coefficients[3];
  }
};
using PixelRow = Eigen::Array<float, 16, 1>;  ///< four neighbours
const CubicPolynomials<1> kRowPolynomials;
const CubicPolynomials<4> kColumnPolynomials;

/// Cubic convolution of 4 x 4 pixels; row(j) are those of a row side by side, and (tx, ty) the place within the middle.
template <typename Row>
[[gnu::always_inline]] inline Pixel convolved(const Row& row, float tx, float ty) {
  const Eigen::Array4f wy = kRowPolynomials.weights(ty);
  PixelRow columns = wy[0] * row(0) + wy[1] * row(1) + wy[2] * row(2) + wy[3] * row(3);
  columns *= kColumnPolynomials.weights(tx);
  const Pixel sum = (columns.segment<4>(0) + columns.segment<4>(4)) + (columns.segment<4>(8) + columns.segment<4>(12));
  return sum.max(0);  // the kernel overshoots at edges; light is never negative
}

Pixel sample_cubic_at_border(const ImageF& image, float x, float y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const auto row = [&](int j) {
    PixelRow pixels;
    for (int i = 0; i < 4; ++i) pixels.segment<4>(4 * i) = texel(image, x0 - 1 + i, y0 - 1 + j);
    return pixels;
  };
  return convolved(row, x - static_cast<float>(x0), y - static_cast<float>(y0));
}

/// The four pixels round a place.
struct Four {
  Four(const ImageF& image, float x, float y) {
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    tx = x - static_cast<float>(x0);
    ty = y - static_cast<float>(y0);
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) pixels[j][i] = texel(image, x0 + i, y0 + j);
  }
  bool clear() const { return pixels[0][0].min(pixels[0][1]).min(pixels[1][0].min(pixels[1][1]))[kClear] == 1; }
  Pixel interpolated() const {
    return (1 - ty) * ((1 - tx) * pixels[0][0] + tx * pixels[0][1]) +
           ty * ((1 - tx) * pixels[1][0] + tx * pixels[1][1]);
  }

  float tx, ty;
  Pixel pixels[2][2];
};

/// Cubic convolution where the nearest pixel is clear, else nothing. Places that are asked for lie mostly far within.
[[gnu::always_inline]] inline bool sample_cubic(const ImageF& image, float x, float y, float* rgb) {
  const bool within =
      (x >= 1) & (y >= 1) & (x < static_cast<float>(image.width() - 2)) & (y < static_cast<float>(image.height() - 2));
  if (!within) {
    if (texel(image, static_cast<int>(x + 0.5f), static_cast<int>(y + 0.5f))[kClear] != 1) return false;
    Eigen::Map<Pixel>{rgb} = sample_cubic_at_border(image, x, y);
    return true;
  }
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float tx = x - static_cast<float>(x0), ty = y - static_cast<float>(y0);
  const float* const middle = image.pixel(x0, y0);
  const std::ptrdiff_t stride = 4 * std::ptrdiff_t{image.width()};
  if (middle[4 * (tx >= 0.5f) + stride * (ty >= 0.5f) + kClear] != 1) return false;
  Eigen::Map<Pixel>{rgb} =
      convolved([&](int j) { return Eigen::Map<const PixelRow>(middle - 4 + (j - 1) * stride); }, tx, ty);
  return true;
}

/// Linear interpolation on the coarsest level up to `level` whose pixels there show one surface only. The full image
/// always does, round a place that may be sampled: its pixel touches no edge.
template <typename Levels>
Pixel sample_own_surface(const Levels& levels, int level, float x, float y) {
  for (; level > 0; --level) {
    const float scale = 1.0f / static_cast<float>(1 << level);
    const float shift = 0.5f * scale - 0.5f;  // pixel centres of a level lie between those of the finer one
    const Four four(levels[level], x * scale + shift, y * scale + shift);
    if (four.clear()) return four.interpolated();
  }
  return Four(levels[0], x, y).interpolated();
}

void halve(const ImageF& fine, ImageF& coarse) {
  coarse.resize((fine.width() + 1) / 2, (fine.height() + 1) / 2, 4);
  tbb::parallel_for(tbb::blocked_range<int>(0, coarse.height(), 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < coarse.width(); ++x)
        Eigen::Map<Pixel>(coarse.pixel(x, y)) =
            0.25f * (texel(fine, 2 * x, 2 * y) + texel(fine, 2 * x + 1, 2 * y) + texel(fine, 2 * x, 2 * y + 1) +
                     texel(fine, 2 * x + 1, 2 * y + 1));
  });
}

void zero_what_is_not_finite(ImageF& image) {
  for (std::size_t i = 0; i < image.size(); i += 4)
    if (Eigen::Map<Pixel> pixel(image.data() + i); !pixel.allFinite()) pixel.setZero();
}

/// The box with what filters read round it, on a grid that the coarser levels share with those of the whole image.
PixelBox padded(const PixelBox& box, const RawImage& image) {
  const auto down = [](int i) { return std::max(i / kBlock - 1, 0) * kBlock; };
  const auto up = [](int i, int size) { return std::min((i / kBlock + 2) * kBlock, size); };
  return {down(box.x0), down(box.y0), up(box.x1, image.width), up(box.y1, image.height)};
}

}  // namespace

RadianceImage::RadianceImage(const ImageF& linear) {
  ImageF& full = levels_[0];
  full = ImageF(linear.width(), linear.height(), 4);
  for (std::size_t i = 0; i < linear.size() / 3; ++i) std::copy_n(linear.data() + 3 * i, 3, full.data() + 4 * i);
  zero_what_is_not_finite(full);
  for (std::size_t i = 0; i < full.size(); i += 4) full.data()[i + kClear] = 1;
  fill_coarser_levels(std::numeric_limits<float>::infinity());
}

void RadianceImage::load(const Capture& capture, const SurfaceView& view) {
  const PixelBox box = padded(view.box, capture.image);
  origin_ = {static_cast<float>(box.x0), static_cast<float>(box.y0)};
  const LinearReader reader = linear_reader(capture);
  ImageF& full = levels_[0];
  full.resize(box.width(), box.height(), 4);
  tbb::parallel_for(tbb::blocked_range<int>(box.y0, box.y1, kStrip), [&](const tbb::blocked_range<int>& rows) {
    reader.read({box.x0, rows.begin(), box.x1, rows.end()}, 4, full.row(rows.begin() - box.y0),
                4 * static_cast<std::size_t>(box.width()));
  });
  if (capture.image.format == PixelFormat::kRGB32f) zero_what_is_not_finite(full);
  fill_edges(view.from_edge, box.x0, box.y0, full);
  tbb::parallel_for(tbb::blocked_range<int>(0, full.height(), 32), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const std::uint8_t* from_edge = view.from_edge.row(box.y0 + y) + box.x0;
      for (int x = 0; x < full.width(); ++x) full.pixel(x, y)[kClear] = from_edge[x] == 2 ? 1.0f : 0.0f;
    }
  });
  fill_coarser_levels(*std::max_element(view.step_px.begin(), view.step_px.end()));
}

void RadianceImage::fill_coarser_levels(float largest_step_px) {
  levels_used_ = 1;
  for (float step = kFullResolutionStep; step < largest_step_px && levels_used_ < int(levels_.size()); step *= 2) {
    halve(levels_[levels_used_ - 1], levels_[levels_used_]);
    ++levels_used_;
  }
}

Eigen::Vector3f RadianceImage::sample(const Eigen::Vector2f& pixel, float step_px, Sampling sampling) const {
  float rgb[4];
  constexpr std::uint8_t kWanted = 1;
  sample({&pixel.x(), 1}, {&pixel.y(), 1}, {&kWanted, 1}, step_px, sampling, rgb);
  return {rgb[0], rgb[1], rgb[2]};
}

void RadianceImage::sample(std::span<const float> pixel_x, std::span<const float> pixel_y,
                           std::span<const std::uint8_t> wanted, float step_px, Sampling sampling, float* rgb) const {
  int level = 0;
  for (float step = kFullResolutionStep; step < step_px && level + 1 < levels_used_; step *= 2) ++level;
  const bool cubic = level == 0 && sampling == Sampling::kCubic;
  for (std::size_t i = 0; i < pixel_x.size(); ++i) {
    if (!wanted[i]) continue;
    const float x = pixel_x[i] - origin_.x(), y = pixel_y[i] - origin_.y();
    if (!cubic || !sample_cubic(levels_[0], x, y, rgb))
      Eigen::Map<Pixel>{rgb} = sample_own_surface(levels_, level, x, y);
    rgb += 3;
  }
}

ImageU8 usable_pixels(const Capture& capture) {
  if (capture.image.format != PixelFormat::kRGB32f) return capture.mask;
  const RawImage& image = capture.image;
  ImageU8 usable = capture.mask;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      Eigen::Array3f rgb;
      std::memcpy(rgb.data(), image.bytes.data() + y * image.stride + 12 * static_cast<std::size_t>(x), 12);
      if (rgb.allFinite()) continue;
      if (usable.empty()) usable = ImageU8(image.width, image.height, 1, 255);
      usable.at(x, y) = 0;
    }
  return usable;
}

ImageF level_radiance(const Capture& capture, float gain) {
  ImageF image = linear_radiance(capture);
  if (gain == 1) return image;
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] *= 1 / gain;
  return image;
}

Capture levelled(Capture capture, float gain) {
  const ImageF linear = level_radiance(capture, gain);
  RawImage& image = capture.image;
  image.format = PixelFormat::kRGB32f;
  image.transfer = Transfer::kLinear;
  image.stride = 3 * sizeof(float) * static_cast<std::size_t>(linear.width());
  image.bytes.resize(sizeof(float) * linear.size());
  std::memcpy(image.bytes.data(), linear.data(), image.bytes.size());
  capture.exposure.black_level = 0;
  capture.exposure.white_balance = {1, 1, 1};
  capture.exposure.exposure_s /= gain;
  capture.photometry.reset();
  return capture;
}

}  // namespace sheen
