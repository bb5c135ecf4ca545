// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/grey_pyramid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/capture/linear_capture.h"
#include "common/image/color.h"

namespace sheen {
namespace {

constexpr float kUnusable = std::numeric_limits<float>::quiet_NaN();
constexpr int kSmallestSide = 16;  // pixels of the coarsest level

ImageF encoded_luminance(const Capture& capture) {
  const ImageF linear = linear_radiance(capture);
  ImageF grey(linear.width(), linear.height(), 1);
  tbb::parallel_for(0, grey.height(), [&](int y) {
    for (int x = 0; x < grey.width(); ++x) {
      const bool ignored = !capture.mask.empty() && capture.mask.at(x, y) == 0;
      const float value = luminance(linear.pixel(x, y));
      grey.at(x, y) = ignored || !std::isfinite(value) ? kUnusable : srgb_encode_fast(value);
    }
  });
  return grey;
}

/// Each pixel is the mean of four; an odd last row or column is left out.
ImageF halved(const ImageF& fine) {
  ImageF coarse(fine.width() / 2, fine.height() / 2, 1);
  for (int y = 0; y < coarse.height(); ++y) {
    const float *above = fine.row(2 * y), *below = fine.row(2 * y + 1);
    for (int x = 0; x < coarse.width(); ++x)
      coarse.at(x, y) = 0.25f * (above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1]);
  }
  return coarse;
}

}  // namespace

GreyPyramid::GreyPyramid(const Capture& capture) {
  levels_.push_back(encoded_luminance(capture));
  while (std::min(levels_.back().width(), levels_.back().height()) >= 2 * kSmallestSide)
    levels_.push_back(halved(levels_.back()));
}

int GreyPyramid::level_for(float step_px) const {
  int level = 0;
  for (float step = std::sqrt(2.0f); step < step_px && level + 1 < static_cast<int>(levels_.size()); step *= 2) ++level;
  return level;
}

float GreyPyramid::sample(int level, float x, float y) const {
  const ImageF& image = levels_[level];
  const float scale = 1.0f / static_cast<float>(1 << level), shift = 0.5f * scale - 0.5f;
  const float u = x * scale + shift, v = y * scale + shift;
  if (!(u >= 0 && v >= 0 && u < static_cast<float>(image.width() - 1) && v < static_cast<float>(image.height() - 1)))
    return kUnusable;
  const int x0 = static_cast<int>(u), y0 = static_cast<int>(v);
  const float s = u - static_cast<float>(x0), t = v - static_cast<float>(y0);
  const float *above = image.pixel(x0, y0), *below = image.pixel(x0, y0 + 1);
  return (1 - t) * ((1 - s) * above[0] + s * above[1]) + t * ((1 - s) * below[0] + s * below[1]);
}

}  // namespace sheen
