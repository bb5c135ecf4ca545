// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_column.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace sheen {

bool shows(const SurfaceView& view, const PatchShape& patch) {
  return std::any_of(patch.triangles.begin(), patch.triangles.end(),
                     [&](std::uint32_t t) { return view.visible_in_triangle[t] > 0; });
}

bool gather(const VertexRings& maps, const PatchShape& patch, const ShownImage& image, PatchColumn& column) {
  if (!shows(image.view, patch)) return false;
  column.visible.resize(patch.samples);
  column.values.resize(3 * Eigen::Index{patch.samples});
  for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
    const std::size_t from = maps.first_sample(patch.triangles[i]);
    const int count = lattice_samples(maps.resolution(patch.triangles[i]));
    const Eigen::Index to = patch.first_sample[i];
    std::copy_n(image.view.visible.begin() + static_cast<std::ptrdiff_t>(from), count, column.visible.begin() + to);
    Eigen::Map<Eigen::Matrix3Xf>(column.values.data() + 3 * to, 3, count) =
        image.samples.middleCols(static_cast<Eigen::Index>(from), count);
  }
  return true;
}

std::vector<float> reliability_at_vertices(const VertexRings& rings, const SurfaceView& view) {
  constexpr float kLeast = 0.003f;
  std::vector<float> reliability(rings.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rings.size(), 256), [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) {
      int visible = 0;
      float cosine = 0;
      for (const RingTriangle& member : rings.ring(v)) {
        const int here = view.visible_in_triangle[member.triangle];
        if (here == 0) continue;
        visible += here;
        cosine = std::max(cosine, view.cosine[member.triangle]);
      }
      const float share = static_cast<float>(visible) / static_cast<float>(std::max(rings.ring_samples(v), 1));
      reliability[v] = std::max(kLeast, cosine * share);
    }
  });
  return reliability;
}

}  // namespace sheen
