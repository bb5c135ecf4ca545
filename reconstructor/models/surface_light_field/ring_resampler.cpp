// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_resampler.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <vector>

#include "common/color.h"

namespace sheen {

void resample(const RadianceImage& image, const SurfaceView& view, const VertexRings& rings, float gain,
              Eigen::Matrix3Xf& encoded, Sampling sampling) {
  encoded.resize(3, static_cast<Eigen::Index>(rings.total_samples()));
  const float scale = 1 / gain;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.cosine.size(), 128), [&](const auto& range) {
    std::vector<float> values;  // of a triangle's visible samples: encoded together
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      if (view.visible_in_triangle[t] == 0) continue;
      values.resize(3 * static_cast<std::size_t>(view.visible_in_triangle[t]));
      const std::size_t first = rings.first_sample(t), end = rings.first_sample(t + 1);
      Eigen::Map<Eigen::Matrix3Xf> colours(values.data(), 3, view.visible_in_triangle[t]);
      Eigen::Index n = 0;
      for (std::size_t s = first; s < end; ++s)
        if (view.visible[s]) colours.col(n++) = scale * image.sample(view.pixel[s], view.step_px[t], sampling);
      srgb_encode_fast(std::span<float>(values));
      n = 0;
      for (std::size_t s = first; s < end; ++s)
        if (view.visible[s]) encoded.col(static_cast<Eigen::Index>(s)) = colours.col(n++);
    }
  });
}

}  // namespace sheen
