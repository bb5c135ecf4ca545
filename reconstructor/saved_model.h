// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "common/progress.h"
#include "reconstructor/reconstruction.h"

namespace sheen {

/// Loads a mesh and tells on standard error what is wrong with it. Throws FileError.
Mesh load_mesh_and_warn(const std::filesystem::path& path);

/// Saves the light field as it stands, unseen parts filled with a guess, and notes which views it never saw. `source`
/// says where the images came from. Until the new model is whole, an older one in
/// the folder stays.
void save_reconstruction(Reconstruction& reconstruction, const std::filesystem::path& folder, const std::string& source,
                         const StepsDone& progress = {});

/// Names of the views that a saved model never saw; empty when it was built from everything.
std::set<std::string> held_out_names(const std::filesystem::path& model_folder);

}  // namespace sheen
