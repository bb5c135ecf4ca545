// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/quantised_field.h"

#include <cmath>

#include "reconstructor/irradiance_field_file/field_coder.h"

namespace sheen {

FieldTerms dequantise(const QuantisedField& field) {
  FieldTerms terms{.size = field.size};
  for (std::size_t c = 0; c < field.components.size(); ++c) {
    const QuantisedField::Component& from = field.components[c];
    FieldTerms::Component& to = terms.components[c];
    const auto count = static_cast<Eigen::Index>(from.terms());
    const auto rows = static_cast<Eigen::Index>(tile_grid(field.size).tiles()) * kTilePixels;
    to.basis = Eigen::Map<const Eigen::MatrixXi>(from.basis.data(), field.lights, count).cast<float>();
    for (Eigen::Index t = 0; t < count; ++t)
      to.basis.col(t) *= std::ldexp(1.0f, -from.bits[static_cast<std::size_t>(t)]);
    to.coefs = field.step * Eigen::Map<const Eigen::MatrixXi>(from.coefs.data(), rows, count).cast<float>();
  }
  return terms;
}

void decode_component(std::string_view bytes, QuantisedField& field, std::size_t component) {
  BitModel bits(field_coder::kContexts);
  ContextDecoder decoder(bits, bytes);
  field_coder::code_component(decoder, field, field.components[component]);
}

}  // namespace sheen
