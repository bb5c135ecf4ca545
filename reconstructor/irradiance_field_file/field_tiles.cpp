// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/field_tiles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheen {
namespace {

const std::array<std::array<int, 2>, kTilePixels>& frequencies() {
  static const auto order = [] {
    std::array<std::array<int, 2>, kTilePixels> list{};
    std::size_t k = 0;
    for (int sum = 0; sum <= 2 * (kTileSide - 1); ++sum)
      for (int x = std::max(0, sum - kTileSide + 1); x <= std::min(sum, kTileSide - 1); ++x) list[k++] = {x, sum - x};
    return list;
  }();
  return order;
}

}  // namespace

TileGrid tile_grid(const ImageSize& size) {
  return {(size.width + kTileSide - 1) / kTileSide, (size.height + kTileSide - 1) / kTileSide};
}

std::array<int, 2> tile_frequency(int k) {
  return frequencies()[static_cast<std::size_t>(k)];
}

const TileMatrix& tile_cosines() {
  static const TileMatrix matrix = [] {
    TileMatrix m;
    for (int u = 0; u < kTileSide; ++u)
      for (int x = 0; x < kTileSide; ++x)
        m(u, x) = static_cast<float>(std::sqrt((u == 0 ? 1.0 : 2.0) / kTileSide) *
                                     std::cos(std::numbers::pi * (x + 0.5) * u / kTileSide));
    return m;
  }();
  return matrix;
}

void tile_from_frequencies(const float* frequency, float* pixels) {
  TileMatrix transformed;
  for (const auto& [u, v] : frequencies()) transformed(v, u) = *frequency++;
  Eigen::Map<TileMatrix>(pixels, kTileSide, kTileSide) = tile_cosines().transpose() * transformed * tile_cosines();
}

Eigen::Matrix3f component_of_colour() {
  Eigen::Matrix3d m;
  m << 1, 1, 1, 1, 0, -1, 1, -2, 1;
  m.rowwise().normalize();
  return m.cast<float>();
}

}  // namespace sheen
