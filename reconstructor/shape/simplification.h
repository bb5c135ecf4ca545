// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "common/geometry/mesh.h"

namespace sheen {

/// The mesh with at most `triangles` triangles by collapse of edges in the order of their quadric error (Garland and
/// Heckbert 1997); with more where its handles need them, or where it would leave the shape by a hundredth of its
/// radius. `detail` is a weight > 0 per vertex, or empty for 1 everywhere: more triangles stay where it is large. A
/// closed 2-manifold stays one, of the same genus; vertices at edges that are not of two triangles, and where several
/// fans of triangles meet, stay where they are. A vertex has the evidence of one of those that it stands for. The same
/// input gives the same bits.
Mesh simplified(Mesh mesh, std::size_t triangles, std::span<const float> detail = {});

}  // namespace sheen
