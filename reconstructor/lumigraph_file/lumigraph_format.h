// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/coding/chunk_file.h"

namespace sheen {

inline constexpr ChunkFormat kLumigraphFileFormat{.magic = "sheenILG", .version = 2, .title = "intrinsic lumigraph"};

}  // namespace sheen
