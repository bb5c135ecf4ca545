// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/coding/bit_model.h"
#include "reconstructor/light_field_file/patch_spectrum.h"

namespace sheen {

/// The patches in layers, so that a reader that has the first ones can draw already: the smooth part of the means, the
/// rest of the means, then a layer per term. A layer is read after all before it.
inline constexpr int kMeanLayers = 2;
inline constexpr std::size_t kSmoothFrequencies = 10;  ///< of a tile, in the first layer of the means

/// What all layers are read with: the number of coefficients of each patch, and the tiles of its lattices.
struct PatchLayout {
  std::vector<std::size_t> images;                      ///< per patch; 0: nothing is known of it
  std::vector<std::vector<int>> tile_sizes;             ///< per patch: of all its triangles
  std::vector<std::vector<std::uint16_t>> haar_parent;  ///< per patch: of each coefficient; unused for the mean
};

/// What was learned of the bits in the layers before: layers are coded one after the other with the same.
struct LayerModels {
  LayerModels();
  BitModel& of(int layer) { return layer < kMeanLayers ? means : terms; }

  BitModel means, terms;
};

/// Adds a layer to `patches`. Throws std::runtime_error.
void decode_layer(const PatchLayout& layout, std::string_view bytes, std::vector<QuantisedPatch>& patches, int layer,
                  LayerModels& models);

}  // namespace sheen
