// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "reconstructor/numerics/row_resampling.h"
#include "reconstructor/surface/colour_planes.h"

namespace sheen {

/// With every second interval, or so; not less than what knows something of the inside.
int half_side(int side);
MapSides half_sides(const MapSides& sides);

/// The rows of a patch whose maps get other sides.
RowResampling resampled_planes(const ColourPlanes& from, const ColourPlanes& to);

/// For each map the side that is enough for what is displayed: the one it has, half or a quarter of it, whichever is
/// the smallest that misses at most `detail` of it, RMS over samples, channels and views. `basis`: of one or more
/// planes, each with all maps, rows x rank; `displayed`: rank x views. In units of their products.
MapSides sufficient_sides(const MapSides& sides, const Eigen::MatrixXf& basis, const Eigen::MatrixXf& displayed,
                          float detail);

}  // namespace sheen
