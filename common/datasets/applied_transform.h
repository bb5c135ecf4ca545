// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>

namespace sheen {

/// What a `transforms.json` (the file, or a folder with it) says was done to its poses after they were reconstructed:
/// `applied_transform`, then `applied_scale`; a point of the reconstruction times this stands in the poses' frame.
/// Empty where it says nothing, or what is no rotation.
std::optional<Eigen::Matrix4d> applied_to_poses(const std::filesystem::path& dataset);

}  // namespace sheen
