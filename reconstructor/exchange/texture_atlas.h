// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/exchange/flat_triangle.h"

namespace sheen {

/// Where a mesh's triangles lie in a square texture: charts of neighbouring triangles side by side, all in one scale.
struct TextureAtlas {
  int side = 0;                         ///< texels
  std::vector<FlatTriangle> triangles;  ///< per triangle; left and right as seen from outside, y runs down
  std::vector<std::uint32_t> chart;     ///< per triangle
};

/// Texels that stay free round every chart, so that mipmaps of the first two levels do not mix neighbours.
inline constexpr int kGutter = 4;

/// As large as the texture takes them. Throws ConfigError where the mesh has so many pieces that they do not fit.
TextureAtlas texture_atlas(const Mesh& mesh, int side);

}  // namespace sheen
