// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"

namespace sheen {

// The folder of an intrinsic lumigraph, docs/intrinsic_lumigraph_format.md: model.json, the mesh, and the views in one
// file of chunks with checksums.

inline constexpr const char* kLumigraphFormat = "intrinsic lumigraph";  ///< "format" in model.json

/// Throws FileError.
void save_lumigraph(const IntrinsicLumigraphSnapshot& model, const std::filesystem::path& folder,
                    const ModelMetadata& metadata, const StepsDone& progress);
/// Throws FileError that names file and chunk.
std::shared_ptr<const IntrinsicLumigraphSnapshot> load_lumigraph(const std::filesystem::path& folder);

}  // namespace sheen
