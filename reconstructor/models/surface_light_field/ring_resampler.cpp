// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_resampler.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "common/color.h"

namespace sheen {
namespace {

constexpr int kLevels = 4;
constexpr float kCubicA = -0.6f;
// Up to this distance between samples the full image is read: the cubic kernel itself passes little beyond it.
constexpr float kFullResolutionStep = 1.6f;

Eigen::Array4f cubic_weights(float t) {
  const auto near = [](float x) { return ((kCubicA + 2) * x - (kCubicA + 3)) * x * x + 1; };
  const auto far = [](float x) { return ((kCubicA * x - 5 * kCubicA) * x + 8 * kCubicA) * x - 4 * kCubicA; };
  return {far(1 + t), near(t), near(1 - t), far(2 - t)};
}

Eigen::Array4f texel(const ImageF& image, int x, int y) {
  return Eigen::Map<const Eigen::Array4f>(
      image.pixel(std::clamp(x, 0, image.width() - 1), std::clamp(y, 0, image.height() - 1)));
}

Eigen::Array4f sample_cubic(const ImageF& image, float x, float y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const Eigen::Array4f wx = cubic_weights(x - x0), wy = cubic_weights(y - y0);
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int j = 0; j < 4; ++j) {
    Eigen::Array4f row = Eigen::Array4f::Zero();
    for (int i = 0; i < 4; ++i) row += wx[i] * texel(image, x0 - 1 + i, y0 - 1 + j);
    sum += wy[j] * row;
  }
  return sum.max(0);  // the kernel overshoots at edges; light is never negative
}

Eigen::Array4f sample_linear(const ImageF& image, float x, float y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const float tx = x - x0, ty = y - y0;
  return (1 - ty) * ((1 - tx) * texel(image, x0, y0) + tx * texel(image, x0 + 1, y0)) +
         ty * ((1 - tx) * texel(image, x0, y0 + 1) + tx * texel(image, x0 + 1, y0 + 1));
}

ImageF halve(const ImageF& fine) {
  ImageF coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2, 4);
  tbb::parallel_for(0, coarse.height(), [&](int y) {
    for (int x = 0; x < coarse.width(); ++x)
      Eigen::Map<Eigen::Array4f>(coarse.pixel(x, y)) =
          0.25f * (texel(fine, 2 * x, 2 * y) + texel(fine, 2 * x + 1, 2 * y) + texel(fine, 2 * x, 2 * y + 1) +
                   texel(fine, 2 * x + 1, 2 * y + 1));
  });
  return coarse;
}

}  // namespace

RadianceImage::RadianceImage(const ImageF& linear) {
  const int w = linear.width(), h = linear.height();
  ImageF full(w, h, 4);
  std::vector<std::uint8_t> row_is_finite(h, 1);
  tbb::parallel_for(0, h, [&](int y) {
    for (int x = 0; x < w; ++x) {
      const Eigen::Map<const Eigen::Array3f> in(linear.pixel(x, y));
      if (in.allFinite())
        Eigen::Map<Eigen::Array3f>(full.pixel(x, y)) = in;
      else
        row_is_finite[y] = 0;
    }
  });
  if (std::find(row_is_finite.begin(), row_is_finite.end(), 0) != row_is_finite.end()) {
    valid_ = ImageU8(w, h, 1, 255);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        if (!Eigen::Map<const Eigen::Array3f>(linear.pixel(x, y)).allFinite()) valid_.at(x, y) = 0;
  }
  levels_.push_back(std::move(full));
  while (levels_.size() < kLevels && levels_.back().width() > 8 && levels_.back().height() > 8)
    levels_.push_back(halve(levels_.back()));
}

Eigen::Vector3f RadianceImage::sample(const Eigen::Vector2f& pixel, float step_px) const {
  if (step_px <= kFullResolutionStep) return sample_cubic(levels_[0], pixel.x(), pixel.y()).head<3>();
  const float wanted = std::log2(step_px / kFullResolutionStep);
  const int level = std::min(static_cast<int>(std::ceil(wanted)), static_cast<int>(levels_.size()) - 1);
  const float scale = 1.0f / (1 << level);
  return sample_linear(levels_[level], (pixel.x() + 0.5f) * scale - 0.5f, (pixel.y() + 0.5f) * scale - 0.5f).head<3>();
}

void resample(const RadianceImage& image, const SurfaceView& view, const VertexRings& rings, float gain,
              Eigen::Matrix3Xf& encoded) {
  encoded.resize(3, static_cast<Eigen::Index>(rings.total_samples()));
  const float scale = 1 / gain;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.cosine.size(), 128), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      if (view.visible_in_triangle[t] == 0) continue;
      for (std::size_t s = rings.first_sample(t); s < rings.first_sample(t + 1); ++s)
        if (view.visible[s]) {
          const Eigen::Vector3f radiance = scale * image.sample(view.pixel[s], view.step_px[t]);
          encoded.col(static_cast<Eigen::Index>(s)) = radiance.unaryExpr(&srgb_encode_fast);
        }
    }
  });
}

}  // namespace sheen
