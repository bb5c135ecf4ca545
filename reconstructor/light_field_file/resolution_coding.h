// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/light_field_file/mesh_coding.h"

namespace sheen {

/// Throws std::runtime_error where one is less than 2 or the bytes are no such stream.
std::vector<std::uint8_t> decode_resolutions(const GridMesh& mesh, std::string_view bytes);

}  // namespace sheen
