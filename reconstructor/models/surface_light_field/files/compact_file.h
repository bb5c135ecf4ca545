// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "reconstructor/models/model_kind.h"
#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"

namespace sheen {

/// Writes the encoded model with this metadata in place of its own. Throws FileError.
void save_compact(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata);

/// `show` gets what can be seen before the rest is decoded: the mesh, then the smooth part of the means; not from the
/// caller's thread. Throws FileError that names the chunk.
std::shared_ptr<const CompactLightField> load_compact(const std::filesystem::path& file, const ShowModel& show = {});
ModelMetadata compact_metadata(std::string_view bytes, const std::string& file);

}  // namespace sheen
