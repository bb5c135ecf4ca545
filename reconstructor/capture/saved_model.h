// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "common/base/progress.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/evaluation/error_calibration.h"
#include "reconstructor/scene/mesh_scale.h"

namespace sheen {

/// Loads a mesh and tells on standard error its size, what is wrong with it, that a model of these options may not fit
/// into the memory, and that the cameras cannot see it. Throws FileError, also where it can only be of another unit or
/// where no model of it fits.
Mesh load_mesh_and_warn(const std::filesystem::path& path, const SurfaceLightFieldOptions& options,
                        std::span<const PosedCamera> cameras);

/// Saves the light field as it stands, unseen parts filled with a guess, and notes its settings and what became of
/// every capture. `source` says where the images came from. Until the new model is whole, an older one in the folder
/// stays.
void save_reconstruction(Reconstruction& reconstruction, const std::filesystem::path& folder, const std::string& source,
                         const StepsDone& progress = {});

/// What the model's predicted errors were off by on its held-out views goes into the saved model, once they are judged.
void note_calibration(const ErrorCalibration& calibration, const std::filesystem::path& model_folder);
/// Not known where nothing was noted: no view was held out, or too few. Throws FileError.
ErrorCalibration load_calibration(const std::filesystem::path& model_folder);

/// What a saved model notes of its making.
struct ModelOrigin {
  SurfaceLightFieldOptions options;
  /// By source session and sequence: names begin again with each run of a tracker. Refused captures are left out.
  std::map<std::pair<std::string, std::uint64_t>, KnownCapture> captures;

  /// Null when the model does not know it.
  const KnownCapture* find(const Capture& capture) const;
};
/// Throws FileError where the model does not say.
ModelOrigin load_origin(const std::filesystem::path& model_folder);

}  // namespace sheen
