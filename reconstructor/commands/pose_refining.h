// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/refinement/pose_judgement.h"

namespace sheen {

/// Throws FileError that says what to do where a data set has no poses that could be written.
void check_poses_can_be_written(const std::filesystem::path& dataset, const std::filesystem::path& out);

/// Refines poses against what the images show of a mesh, judges them, and says on standard output what came of it.
/// `report`: what `refine --json` writes of it. Throws Error where it is to stop before it is done.
JudgedPoses refine_poses_and_print(const Mesh& mesh, const PosedImages& posed, nlohmann::json& report);

/// A `transforms.json` with the images of a data set and these poses. Throws FileError where there are not as many.
void write_poses(const std::filesystem::path& dataset, const std::vector<PosedCamera>& poses,
                 const std::filesystem::path& out);

}  // namespace sheen
