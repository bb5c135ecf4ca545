// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "reconstructor/lumigraph_file/lumigraph_data.h"

namespace sheen {

/// The views' file, docs/intrinsic_lumigraph_format.md. Throws FileError that names file and chunk.
LumigraphData read_lumigraph(std::string_view bytes, const std::string& file);

}  // namespace sheen
