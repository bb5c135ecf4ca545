// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "common/image/image.h"
#include "common/parallel/for_each.h"
#include "reconstructor/irradiance_field_file/field_terms.h"

namespace sheen {

/// The terms as maps of pixels, ready to be summed: each tile has those alone that are not zero in it. Immutable.
class Relighting {
 public:
  Relighting(const FieldTerms& field, const ForEach& for_each);

  /// The picture that is this weighted sum of the images, sRGB-encoded in grey levels of 255, not clamped; 3 channels.
  ImageF encoded_picture(const Eigen::VectorXf& weights, const ForEach& for_each) const;
  /// Number of terms of each tile, all colour components together.
  std::vector<std::size_t> ranks() const;
  std::size_t bytes() const;  ///< of the maps

 private:
  struct Tile {
    std::array<std::vector<std::uint16_t>, 3> terms;  ///< per component: which
    std::vector<float> scales;                        ///< of each of them, in that order
    std::vector<std::int16_t> pixels;                 ///< kTilePixels of each: what a picture reads is halved so
  };
  ImageSize size_;
  std::array<Eigen::MatrixXf, 3> basis_;  ///< n x terms
  std::vector<Tile> tiles_;
};

/// Grey levels in 8 bits, clamped.
ImageU8 rounded_levels(const ImageF& picture, const ForEach& for_each);
/// Linear radiance of encoded grey levels; below 0 becomes 0.
void decode_levels(ImageF& picture, const ForEach& for_each);

}  // namespace sheen
