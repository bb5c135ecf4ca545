// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/capture/training_images.h"
#include "reconstructor/refinement/mesh_judgement.h"
#include "reconstructor/refinement/pose_judgement.h"

namespace sheen {

/// Throws FileError that says what to do where the poses of a data set come from a stage.
void check_poses_can_be_refined(const std::filesystem::path& dataset);

/// Refines poses against what the images show of a mesh and judges them. `report`: what `refine --json` writes of it.
/// Throws Error where it is to stop before it is done.
JudgedPoses judge_poses(const Mesh& mesh, const PosedImages& posed, nlohmann::json& report);

/// The same, and says on standard output what came of it.
JudgedPoses refine_poses_and_print(const Mesh& mesh, const PosedImages& posed, nlohmann::json& report);

/// Poses on a wrong mesh fit its errors, and a mesh takes in those of poses: in turn, the mesh from what was given each
/// time, until no poses gain. Returns what the last mesh rests on; `posed` has the last poses.
JudgedMesh refine_in_turn(const Mesh& mesh, PosedImages& posed, nlohmann::json& report);

/// A `transforms.json` with the images of a data set and these poses. Throws FileError where there are not as many.
void write_poses(const std::filesystem::path& dataset, const std::vector<PosedCamera>& poses,
                 const std::filesystem::path& out);

}  // namespace sheen
