// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "reconstructor/models/irradiance_field/irradiance_field_snapshot.h"

namespace sheen {

// An irradiance field in one file, docs/irradiance_field_format.md: chunks with checksums. A saved folder holds the
// same file beside its model.json.

inline constexpr const char* kFieldFormat = "irradiance field";  ///< "format" in model.json

/// Throws FileError that names file and chunk.
std::shared_ptr<const IrradianceFieldSnapshot> decode_field(std::string_view bytes, const std::string& file,
                                                            bool in_one_file);

/// Writes what `encode_field` gave with this metadata. Throws FileError.
void save_field_file(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata);
void save_field_folder(const std::filesystem::path& folder, std::string_view encoded, const ModelMetadata& metadata);
/// Opens either.
std::shared_ptr<const IrradianceFieldSnapshot> load_field(const std::filesystem::path& path);
ModelMetadata field_file_metadata(const std::filesystem::path& file);

}  // namespace sheen
