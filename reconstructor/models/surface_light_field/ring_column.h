// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "reconstructor/surface/ring_visibility.h"
#include "reconstructor/surface/vertex_ring.h"

namespace sheen {

/// What one image shows of one ring: a column of the ring's matrix (000 sec. 4.1) and where it was seen from.
struct RingColumn {
  Eigen::VectorXf values;             ///< 3 x ring samples, encoded; meaningless where not visible
  std::vector<std::uint8_t> visible;  ///< a ring sample
  Eigen::Vector3f direction;          ///< unit, from the ring's vertex to the camera, object frame
  float cosine = 0;                   ///< the largest of the visible triangles: how squarely the ring was seen
};

/// Gathers the column of the ring round vertex `vertex`, which lies at `place`. `encoded`: 3 x samples of all
/// triangles, as `resample` leaves them. False when no sample of the ring is visible; the column is then unchanged. Its
/// buffers are reused.
bool gather(const VertexRings& rings, std::size_t vertex, const Eigen::Vector3f& place, const SurfaceView& view,
            const Eigen::Matrix3Xf& encoded, RingColumn& column);

}  // namespace sheen
