// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "common/image/image.h"

namespace sheen {

/// A picture is cut into squares of this many pixels; at the right and at the bottom its last pixels are repeated.
inline constexpr int kTileSide = 16, kTilePixels = kTileSide * kTileSide;

struct TileGrid {
  int across = 0, down = 0;
  std::size_t tiles() const { return std::size_t(across) * std::size_t(down); }
};
TileGrid tile_grid(const ImageSize& size);

/// Frequency k of a tile's cosine transform: that along x and that along y. By growing sum, so that the smooth ones
/// come first; k < kTilePixels.
std::array<int, 2> tile_frequency(int k);

using TileMatrix = Eigen::Matrix<float, kTileSide, kTileSide, Eigen::RowMajor>;
/// Orthonormal DCT-II: row u is the cosine of frequency u.
const TileMatrix& tile_cosines();

/// Pixels of a tile from its frequencies.
void tile_from_frequencies(const float* frequencies, float* pixels);

/// The three colours of a pixel in an orthonormal basis: brightness, and two differences.
Eigen::Matrix3f component_of_colour();

}  // namespace sheen
