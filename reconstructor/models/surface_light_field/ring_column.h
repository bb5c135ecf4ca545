// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "reconstructor/numerics/shared_rows.h"
#include "reconstructor/surface/ring_visibility.h"
#include "reconstructor/surface/vertex_ring.h"

namespace sheen {

/// Where from and how far one image shows one ring.
struct RingSight {
  std::vector<std::uint8_t> visible;  ///< per ring sample
  Eigen::Vector3f direction;          ///< unit, from the ring's vertex to the camera, object frame
  float cosine = 0;                   ///< the largest of the visible triangles: how squarely the ring was seen
};

/// The same, with a column of the ring's matrix (000 sec. 4.1).
struct RingColumn : RingSight {
  Eigen::VectorXf values;  ///< 3 x ring samples, encoded; meaningless where not visible
};

/// Of the ring round vertex `vertex`, which lies at `place`. False when no sample of the ring is visible; `sight` is
/// then unchanged. Its buffers are reused.
bool look_at(const VertexRings& rings, std::size_t vertex, const Eigen::Vector3f& place, const SurfaceView& view,
             RingSight& sight);
/// The same. `encoded`: 3 x samples of all triangles, as `resample` leaves them.
bool gather(const VertexRings& rings, std::size_t vertex, const Eigen::Vector3f& place, const SurfaceView& view,
            const Eigen::Matrix3Xf& encoded, RingColumn& column);

/// What an image shows of each triangle, encoded: the runs that columns of rings are made of. Without values where it
/// shows nothing.
using TriangleRuns = std::vector<SharedRows<float>>;
TriangleRuns triangle_runs(const VertexRings& rings, const SurfaceView& view, const Eigen::Matrix3Xf& encoded);
/// The column of a ring.
std::vector<SharedRows<float>> runs_of(const VertexRings& rings, std::size_t vertex, const TriangleRuns& triangles);

}  // namespace sheen
