// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/parallel/for_each.h"
#include "reconstructor/light_field_file/file_layout.h"

namespace sheen {

/// Whether a file begins like a surface light field.
bool is_light_field_file(std::string_view start);

/// A model on its way out of a file: whole numbers still, of which maps and coefficients are to be made.
struct QuantisedModel {
  CompactModel model;  ///< but for the maps and coefficients of its patches
  FileLayout layout;
  std::vector<QuantisedPatch> patches;

  /// The model, whose maps take many times the room. Triangles with a common edge take the mean of both along it.
  CompactModel dequantised(const ForEach& for_each) &&;
};

/// What a reader can show before the rest is decoded. Called on the caller's thread.
struct WhileDecoding {
  std::function<void(const CompactModel&)> mesh;  ///< mesh and cameras are there
  std::function<void(QuantisedModel)> smooth;     ///< the smooth part of the means is there, too
};

/// What such a file (docs/model_format.md), or its beginning, holds: chunks with checksums, the most important first.
/// What is missing leaves the model coarser (`CompactModel::missing_layers`), but all up to the first layer of the
/// means must be there. Throws FileError that names `file` and the chunk.
QuantisedModel read_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show = {});
/// The model itself.
CompactModel decode_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show = {});

}  // namespace sheen
