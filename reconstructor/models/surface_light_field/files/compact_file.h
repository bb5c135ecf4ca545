// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "reconstructor/models/model_kind.h"
#include "reconstructor/models/surface_light_field/compact/canonical_mesh.h"
#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"
#include "reconstructor/models/surface_light_field/compact/patch_spectrum.h"

namespace sheen {

/// A surface light field in one file, docs/model_format.md: chunks with checksums, the most important first, so that a
/// reader of its beginning has a coarser model. `step`: of `quantise`. `model`: what it knows of its vertices becomes
/// what a reader finds in the file.
std::string encode_compact(CompactModel& model, const CanonicalMesh& mesh, float step, const Rounding& rounding);

/// Whether a file begins like one.
bool is_compact(std::string_view start);

/// The model of such a file, or of its beginning: what is missing of it leaves it coarser, but all up to the first
/// layer of the means must be there. `show` gets what can be seen before the rest is decoded: the mesh, then the smooth
/// part of the means; not from the caller's thread. Throws FileError that names the chunk.
CompactModel decode_compact(std::string_view bytes, const std::string& file, const ShowModel& show = {});

/// Writes the encoded model with this metadata in place of its own. Throws FileError.
void save_compact(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata);

std::shared_ptr<const CompactLightField> load_compact(const std::filesystem::path& file, const ShowModel& show = {});
ModelMetadata compact_metadata(std::string_view bytes, const std::string& file);

}  // namespace sheen
