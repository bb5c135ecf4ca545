// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/models/surface_light_field/compact/mesh_coding.h"

namespace sheen {

/// Lattice resolutions of a mesh's triangles. Most follow from the triangle's longest edge, by samples per length: how
/// they differ from that.
std::string encode_resolutions(const GridMesh& mesh, const std::vector<std::uint8_t>& resolutions);

/// Throws std::runtime_error where one is less than 2 or the bytes are no such stream.
std::vector<std::uint8_t> decode_resolutions(const GridMesh& mesh, std::string_view bytes);

}  // namespace sheen
