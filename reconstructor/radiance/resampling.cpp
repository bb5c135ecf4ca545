// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/radiance/resampling.h"

#include <span>
#include <vector>

#include "common/image/color.h"

namespace sheen {

void resample(const SurfaceImage& from, std::size_t t, Eigen::Ref<Eigen::Matrix3Xf> encoded) {
  const SurfaceView& view = from.view;
  const int visible = view.visible_in_triangle[t];
  if (visible == 0) return;
  const std::size_t first = from.maps.first_sample(t), samples = from.maps.first_sample(t + 1) - first;
  const std::span<const std::uint8_t> shown = std::span(view.visible).subspan(first, samples);
  thread_local std::vector<float> values;
  values.resize(3 * static_cast<std::size_t>(visible) + 1);
  const auto [x, y, z] = view.places->of(t);
  from.image.sample(x, y, shown, view.step_px[t], from.sampling, values.data());
  if (from.gain != 1)
    for (float& v : values) v *= 1 / from.gain;
  srgb_encode_fast(std::span(values).first(values.size() - 1));
  const Eigen::Map<const Eigen::Matrix3Xf> colours(values.data(), 3, visible);
  Eigen::Index n = 0;
  for (std::size_t s = 0; s < samples; ++s)
    if (shown[s]) encoded.col(static_cast<Eigen::Index>(s)) = colours.col(n++);
}

}  // namespace sheen
