// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/mesh.h"
#include "reconstructor/shape/block_field.h"
#include "reconstructor/shape/one_piece.h"

namespace sheen {

struct ClosedSurface {
  Mesh mesh;                       ///< empty where no point lies inside
  PieceCounts counts;              ///< what was filled and left out
  std::size_t forced_outside = 0;  ///< points inside at the lattice's border: the object is cut off there
};

/// The surface where a field is zero: closed, one piece, without cavities, every edge of two triangles, every vertex of
/// one fan. Marching tetrahedra (Freudenthal's six in each cube), whose surface is a 2-manifold whatever the signs are.
/// Points of the lattice's border lie outside, and so do NaN. Vertices lie on the edges of the lattice at least
/// `kVertexMargin` of the edge away from its ends, so that every triangle has an area.
ClosedSurface closed_surface(const BlockField& field);

inline constexpr double kVertexMargin = 0.02;

}  // namespace sheen
