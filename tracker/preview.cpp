// SPDX-License-Identifier: Apache-2.0
#include "tracker/preview.h"

#include <cmath>

#include "common/image/color.h"
#include "common/image/linear_reader.h"

namespace sheen {
namespace {

constexpr int kFar = 8;              // pixels of the halved picture
constexpr std::uint8_t kDark = 3;    // grey levels: a hundredth of full scale
constexpr double kTooBright = 0.02;  // of the pixels at full scale; highlights stay below
constexpr double kTooDark = 0.08;    // mean of full scale

/// Means of 2 x 2 pixels: a mosaic's sites mix, and noise is halved.
ImageF halved(const ImageU8& image) {
  ImageF half(image.width() / 2, image.height() / 2, 1);
  for (int y = 0; y < half.height(); ++y)
    for (int x = 0; x < half.width(); ++x)
      half.at(x, y) = 0.25f * static_cast<float>(image.at(2 * x, 2 * y) + image.at(2 * x + 1, 2 * y) +
                                                 image.at(2 * x, 2 * y + 1) + image.at(2 * x + 1, 2 * y + 1));
  return half;
}

double squared_differences(const ImageF& image, int apart) {
  double sum = 0;
  for (int y = 0; y + apart < image.height(); ++y)
    for (int x = 0; x + apart < image.width(); ++x) {
      const float here = image.at(x, y);
      sum += std::pow(image.at(x + apart, y) - here, 2) + std::pow(image.at(x, y + apart) - here, 2);
    }
  return sum / std::max(1, (image.height() - apart) * (image.width() - apart));
}

}  // namespace

ImageLook inspect(const RawImage& image, TagDetector& detector) {
  ImageLook look;
  const std::size_t row_bytes = bytes_per_pixel(image.format) * static_cast<std::size_t>(image.width);
  double sum = 0, clipped = 0, dark = 0;
  for (int y = 0; y < image.height; ++y)
    for (std::size_t x = 0; x < row_bytes; ++x) {
      const std::uint8_t value = image.bytes[static_cast<std::size_t>(y) * image.stride + x];
      sum += value;
      clipped += value == 255;
      dark += value < kDark;
    }
  const double count = static_cast<double>(row_bytes) * image.height;
  look.mean = sum / count / 255;
  look.clipped = clipped / count;
  look.dark = dark / count;
  const ImageU8 grey = detection_image(image);
  const ImageF half = halved(grey);
  const double coarse = squared_differences(half, kFar);
  if (coarse > 0) look.focus = squared_differences(half, 1) / coarse;
  look.tags = detector.detect(grey).size();
  return look;
}

std::string advice(const ImageLook& look) {
  if (look.clipped > kTooBright) return "too bright: shorten the exposure";
  if (look.mean < kTooDark) return "too dark: lengthen the exposure, or add light";
  if (look.tags == 0) return "no tag of the stage is seen: show it, or turn the lens";
  return {};
}

ImageU8 viewable(const RawImage& image) {
  return to_srgb8(to_linear_rgb(image));
}

}  // namespace sheen
