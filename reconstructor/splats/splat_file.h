// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "reconstructor/splats/splats.h"

namespace sheen {

/// Of a file of one splat more, header left out.
std::size_t splat_bytes(int degree);

/// Binary PLY as Kerbl et al. 2023 write it: x y z nx ny nz f_dc f_rest opacity scale rot; logarithms of deviations,
/// logits of opacities, quaternions w x y z. In the frame of the mesh's file, whose `origin` it is given, metres.
/// Throws FileError.
void write_splats(const std::filesystem::path& path, const Splats& splats, const Eigen::Vector3d& origin);

}  // namespace sheen
