// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "reconstructor/irradiance_field_file/lit_scene.h"
#include "reconstructor/irradiance_field_file/quantised_field.h"

namespace sheen {

QuantisedField quantise(const FieldTerms& field, int lights, float step);

/// One colour component as bits in contexts; exact.
std::string encode_component(const QuantisedField& field, std::size_t component);
/// The file, docs/irradiance_field_format.md, without notes.
std::string encode_field(const LitScene& scene, const QuantisedField& field);

}  // namespace sheen
