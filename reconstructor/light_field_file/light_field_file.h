// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/light_field_reader.h"

namespace sheen {

/// Whether a file begins like a surface light field.
bool is_light_field_file(std::string_view start);

/// What a reader can show before the rest is decoded. Called on the caller's thread.
struct WhileDecoding {
  std::function<void(const CompactModel&)> mesh;  ///< mesh and cameras are there
  std::function<void(QuantisedModel)> smooth;     ///< the smooth part of the means is there, too
};

/// What such a file, or its beginning, holds, as `LightFieldReader` has it. Throws FileError that names `file` and the
/// chunk.
QuantisedModel read_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show = {});
/// The model itself.
CompactModel decode_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show = {});

}  // namespace sheen
