// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

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

/// The three colours of a pixel in an orthonormal basis: brightness, and two differences.
Eigen::Matrix3f component_of_colour();

/// Images of one scene in n lights, sRGB-encoded in grey levels of 255, as sums of few products: for each of three
/// colour components, image i is sum_t basis(i, t) * map_t.
struct FieldTerms {
  struct Component {
    Eigen::MatrixXf basis;  ///< n x terms, orthonormal columns, the strongest first
    Eigen::MatrixXf coefs;  ///< (tiles x kTilePixels) x terms: the maps' orthonormal cosine transform, tile by tile
  };
  ImageSize size;
  std::array<Component, 3> components;
};

/// The terms of all images but those that are fainter than `least_rms` grey levels. `gram` becomes the images' products
/// with each other, n x n, summed over pixels and colours. Images: 3 channels, all of one size.
FieldTerms find_terms(std::span<const ImageF> images, double least_rms, Eigen::MatrixXd& gram);

/// Pixels of a tile from its frequencies.
void tile_from_frequencies(const float* frequencies, float* pixels);

}  // namespace sheen
