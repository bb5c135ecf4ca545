// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "reconstructor/irradiance_field_file/field_terms.h"

namespace sheen {

/// `FieldTerms` in whole numbers. All frequencies of all maps have one step: since both transforms are orthonormal, it
/// is that of one distortion for the whole scene, and a map is kept where it rises above it. So each tile has the rank
/// that it needs.
struct QuantisedField {
  struct Component {
    std::vector<std::uint8_t> bits;   ///< per term: its column of the basis is in units of 2^-bits
    std::vector<std::int32_t> basis;  ///< n x terms, term by term
    std::vector<std::int32_t> coefs;  ///< (tiles x kTilePixels) x terms, term by term: units of `step`
    std::size_t terms() const { return bits.size(); }
  };
  ImageSize size;
  int lights = 0;
  float step = 1;  ///< grey levels
  std::array<Component, 3> components;
};

FieldTerms dequantise(const QuantisedField& field);

/// Reads one colour component. `field` has its size and lights, and the component as many `bits` as terms. Throws
/// std::runtime_error for bytes that are none.
void decode_component(std::string_view bytes, QuantisedField& field, std::size_t component);

}  // namespace sheen
