// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string_view>

#include "reconstructor/coding/chunk_file.h"

namespace sheen {

inline constexpr ChunkFormat kFieldFileFormat{.magic = "sheenRIF", .version = 2, .title = "irradiance field"};
inline constexpr std::array<std::string_view, 3> kMapChunks{"MAP0", "MAP1", "MAP2"};

}  // namespace sheen
