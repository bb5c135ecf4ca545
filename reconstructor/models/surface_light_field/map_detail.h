// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "reconstructor/numerics/row_resampling.h"

namespace sheen {

/// Side of each of a patch's surface maps, a triangle after the other.
using MapSides = std::vector<std::uint8_t>;

/// The rows of a patch whose maps get other sides.
RowResampling resampled_maps(const MapSides& from, const MapSides& to);

/// For each map the side that is enough for what is displayed: the one it has, half or a quarter of it, whichever is
/// the smallest that misses at most `detail` of it, RMS over samples, channels and views. `basis`: rows x rank;
/// `displayed`: rank x views. In units of their products.
MapSides sufficient_sides(const MapSides& sides, const Eigen::MatrixXf& basis, const Eigen::MatrixXf& displayed,
                          float detail);

}  // namespace sheen
