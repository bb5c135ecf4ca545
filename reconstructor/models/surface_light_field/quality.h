// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "reconstructor/models/surface_quality.h"

namespace sheen {

struct SeenVertex;

/// The error is kriging's own: the sill, which says how well the vertex's images predict each other, times the variance
/// of what is seen from there given the images. `common_sill`: of all vertices (`LightFieldSnapshot::common_sill`);
/// it counts for one image beside the vertex's own.
SurfaceQuality assess_vertex(const SeenVertex& vertex, const Eigen::Vector3f& direction, float common_sill);

/// A triangle is known as well as the mean of its vertices, and is unseen when any of them is.
SurfaceQuality combine(const SurfaceQuality& a, const SurfaceQuality& b, const SurfaceQuality& c);

}  // namespace sheen
