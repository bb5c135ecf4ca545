// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/light_field_file/resolution_coding.h"

namespace sheen {

/// Lattice resolutions of a mesh's triangles. Most follow from the triangle's longest edge, by samples per length: how
/// they differ from that.
std::string encode_resolutions(const GridMesh& mesh, const std::vector<std::uint8_t>& resolutions);

}  // namespace sheen
