// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "reconstructor/exchange/textured_mesh.h"

namespace sheen {

/// Turns an object frame so that `up` is the +Y of what is written: the axis of the frame that is nearest to it, and
/// the others round it, so that no number is rounded.
Eigen::Matrix3f upright(const Eigen::Vector3d& up);

/// Binary glTF 2.0: +Y up, metres from the mesh's origin, KHR_materials_unlit (light is in the picture), JPEG. Throws
/// FileError.
void write_glb(const std::filesystem::path& path, const TexturedMesh& mesh, const Eigen::Matrix3f& turn);

/// Binary PLY in the frame of the mesh's file: x y z nx ny nz s t (t up) and, for programs without textures, red green
/// blue of the vertices. The picture lies beside it as PNG, by a TextureFile comment. Throws FileError.
void write_textured_ply(const std::filesystem::path& path, const TexturedMesh& mesh);

/// OBJ in the frame of the mesh's file, with an MTL file and a PNG of the same name beside it. Throws FileError.
void write_obj(const std::filesystem::path& path, const TexturedMesh& mesh);

}  // namespace sheen
