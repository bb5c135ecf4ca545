// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_column.h"

#include <algorithm>

namespace sheen {

bool gather(const VertexRings& rings, std::size_t vertex, const Eigen::Vector3f& place, const SurfaceView& view,
            const Eigen::Matrix3Xf& encoded, RingColumn& column) {
  const auto ring = rings.ring(vertex);
  if (std::none_of(ring.begin(), ring.end(),
                   [&](const RingTriangle& member) { return view.visible_in_triangle[member.triangle] > 0; }))
    return false;
  column.values.resize(3 * rings.ring_samples(vertex));
  column.visible.resize(static_cast<std::size_t>(rings.ring_samples(vertex)));
  column.direction = (view.eye.cast<float>() - place).normalized();
  column.cosine = 0;
  for (const RingTriangle& member : ring) {
    const auto first = static_cast<Eigen::Index>(rings.first_sample(member.triangle));
    const int count = lattice_samples(rings.resolution(member.triangle));
    Eigen::Map<Eigen::Matrix3Xf>(column.values.data() + 3 * member.first_sample, 3, count) =
        encoded.middleCols(first, count);
    std::copy_n(view.visible.begin() + first, count, column.visible.begin() + member.first_sample);
    if (view.visible_in_triangle[member.triangle] > 0)
      column.cosine = std::max(column.cosine, view.cosine[member.triangle]);
  }
  return true;
}

}  // namespace sheen
