// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "reconstructor/irradiance_field_file/lit_scene.h"
#include "reconstructor/irradiance_field_file/quantised_field.h"

namespace sheen {

/// An irradiance field as its file holds it, docs/irradiance_field_format.md.
struct StoredField {
  LitScene scene;
  QuantisedField field;
};

/// Whether a file begins like one.
bool is_field_file(std::string_view start);
/// Throws FileError that names file and chunk.
StoredField read_field(std::string_view bytes, const std::string& file);

}  // namespace sheen
