// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "reconstructor/irradiance_field_file/field_tiles.h"

namespace sheen {

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

}  // namespace sheen
