// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/ring_column.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/scalable_allocator.h>

#include <algorithm>

namespace sheen {

bool look_at(const VertexRings& rings, std::size_t vertex, const Eigen::Vector3f& place, const SurfaceView& view,
             RingSight& sight) {
  const auto ring = rings.ring(vertex);
  if (std::none_of(ring.begin(), ring.end(),
                   [&](const RingTriangle& member) { return view.visible_in_triangle[member.triangle] > 0; }))
    return false;
  sight.visible.resize(static_cast<std::size_t>(rings.ring_samples(vertex)));
  sight.direction = (view.eye.cast<float>() - place).normalized();
  sight.cosine = 0;
  for (const RingTriangle& member : ring) {
    std::copy_n(view.visible.begin() + static_cast<std::ptrdiff_t>(rings.first_sample(member.triangle)),
                lattice_samples(rings.resolution(member.triangle)), sight.visible.begin() + member.first_sample);
    if (view.visible_in_triangle[member.triangle] > 0)
      sight.cosine = std::max(sight.cosine, view.cosine[member.triangle]);
  }
  return true;
}

bool gather(const VertexRings& rings, std::size_t vertex, const Eigen::Vector3f& place, const SurfaceView& view,
            const Eigen::Matrix3Xf& encoded, RingColumn& column) {
  if (!look_at(rings, vertex, place, view, column)) return false;
  column.values.resize(3 * rings.ring_samples(vertex));
  for (const RingTriangle& member : rings.ring(vertex)) {
    const int count = lattice_samples(rings.resolution(member.triangle));
    Eigen::Map<Eigen::Matrix3Xf>(column.values.data() + 3 * member.first_sample, 3, count) =
        encoded.middleCols(static_cast<Eigen::Index>(rings.first_sample(member.triangle)), count);
  }
  return true;
}

TriangleRuns triangle_runs(const VertexRings& rings, const SurfaceView& view, const Eigen::Matrix3Xf& encoded) {
  TriangleRuns runs(view.visible_in_triangle.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, runs.size(), 128), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      const int samples = lattice_samples(rings.resolution(t));
      runs[t].rows = 3 * samples;
      if (view.visible_in_triangle[t] == 0) continue;
      const auto first = static_cast<Eigen::Index>(rings.first_sample(t));
      // Other threads let go of it, of thousands at once: the allocator is for that.
      const auto values = std::allocate_shared_for_overwrite<float[]>(tbb::scalable_allocator<float>(),
                                                                      static_cast<std::size_t>(runs[t].rows));
      if (view.visible_in_triangle[t] == samples) {
        runs[t].peak = copy_and_peak(encoded.col(first).data(), runs[t].rows, values.get());
      } else {
        Eigen::Matrix3Xf shown = encoded.middleCols(first, samples);
        for (int s = 0; s < samples; ++s)
          if (!view.visible[static_cast<std::size_t>(first + s)]) shown.col(s).setZero();
        runs[t].peak = copy_and_peak(shown.data(), runs[t].rows, values.get());
      }
      runs[t].values = values;
    }
  });
  return runs;
}

std::vector<SharedRows<float>> runs_of(const VertexRings& rings, std::size_t vertex, const TriangleRuns& triangles) {
  std::vector<SharedRows<float>> runs;
  runs.reserve(rings.ring(vertex).size());
  for (const RingTriangle& member : rings.ring(vertex)) runs.push_back(triangles[member.triangle]);
  return runs;
}

}  // namespace sheen
