// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "reconstructor/exchange/textured_mesh.h"

namespace sheen {

inline constexpr int kMostUsdzSide = 2048;  ///< texels of its picture; telephones take no more

/// USDZ: +Y up, metres from the mesh's origin; a UsdPreviewSurface that shines by itself, as the light is in the
/// picture (JPEG). `turn`: as of `write_glb`. Throws FileError, also for a picture that is larger.
void write_usdz(const std::filesystem::path& path, const TexturedMesh& mesh, const Eigen::Matrix3f& turn);

}  // namespace sheen
