// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/resampling.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <span>
#include <vector>

#include "common/image/color.h"

namespace sheen {

namespace {

/// `values`: a buffer that is reused.
void resample_triangle(const RadianceImage& image, const SurfaceView& view, const MapLayout& maps, std::size_t t,
                       float gain, Eigen::Matrix3Xf& encoded, Sampling sampling, std::vector<float>& values) {
  const int visible = view.visible_in_triangle[t];
  if (visible == 0) return;
  const std::size_t first = maps.first_sample(t), samples = maps.first_sample(t + 1) - first;
  const std::span<const std::uint8_t> shown = std::span(view.visible).subspan(first, samples);
  values.resize(3 * static_cast<std::size_t>(visible) + 1);
  image.sample(std::span(view.pixel).subspan(view.first[t], samples), shown, view.step_px[t], sampling, values.data());
  if (gain != 1)
    for (float& v : values) v *= 1 / gain;
  srgb_encode_fast(std::span(values).first(values.size() - 1));
  const Eigen::Map<const Eigen::Matrix3Xf> colours(values.data(), 3, visible);
  Eigen::Index n = 0;
  for (std::size_t s = 0; s < samples; ++s)
    if (shown[s]) encoded.col(static_cast<Eigen::Index>(view.first[t] + s)) = colours.col(n++);
}

/// Room for the samples that face the camera; it only grows, for they are others in each image.
void make_room(const SurfaceView& view, Eigen::Matrix3Xf& encoded) {
  const auto samples = static_cast<Eigen::Index>(view.pixel.size());
  if (encoded.cols() < samples) encoded.resize(3, samples);
}

}  // namespace

void resample(const RadianceImage& image, const SurfaceView& view, const MapLayout& maps, float gain,
              Eigen::Matrix3Xf& encoded, Sampling sampling) {
  make_room(view, encoded);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.cosine.size(), 128), [&](const auto& range) {
    std::vector<float> values;
    for (std::size_t t = range.begin(); t < range.end(); ++t)
      resample_triangle(image, view, maps, t, gain, encoded, sampling, values);
  });
}

void resample(const RadianceImage& image, const SurfaceView& view, const MapLayout& maps,
              std::span<const std::uint32_t> triangles, float gain, Eigen::Matrix3Xf& encoded, Sampling sampling) {
  make_room(view, encoded);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, triangles.size(), 128), [&](const auto& range) {
    std::vector<float> values;
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      resample_triangle(image, view, maps, triangles[i], gain, encoded, sampling, values);
  });
}

}  // namespace sheen
