// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "reconstructor/shape/shape.h"

namespace sheen {

/// PLY with `evidence` per vertex: 2 seen by images, 1 bounded by outlines, 0 guessed. Throws FileError.
void save_shape(const FoundShape& shape, const std::filesystem::path& path);

}  // namespace sheen
