// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/base/progress.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/evaluation/error_calibration.h"
#include "reconstructor/models/model_kind.h"

namespace sheen {

/// Every saved model that is a folder has it: {"format": ..., "metadata": {...}, ...}.
inline constexpr const char* kModelJsonFile = "model.json";

/// Saves the model as it stands, unseen parts filled with a guess, and notes its settings and what became of
/// every capture. `source` says where the images came from. Until the new model is whole, an older one in the folder
/// stays.
void save_reconstruction(Reconstruction& reconstruction, const std::filesystem::path& folder, const std::string& source,
                         const StepsDone& progress = {});

/// Saves it as one small file, judged on the held-out views.
CompressedModel save_compressed(Reconstruction& reconstruction, const std::filesystem::path& file,
                                const std::string& source, CompressionTarget target);

/// How the model was judged on its held-out views, and what its predicted errors were off by there, goes into the saved
/// model.
void note_judgement(const Scores& scores, const std::filesystem::path& model);

/// What a saved model notes of its making.
struct ModelOrigin {
  std::unique_ptr<ModelSettings> settings;
  /// By source session and sequence: names begin again with each run of a tracker. Refused captures are left out.
  std::map<std::pair<std::string, std::uint64_t>, KnownCapture> captures;

  /// Null when the model does not know it.
  const KnownCapture* find(const Capture& capture) const;
};

struct SavedModel {
  const ModelKind* kind = nullptr;
  std::shared_ptr<const ModelSnapshot> snapshot;
  ModelMetadata metadata;
};
/// Opens a saved model, a folder or a file, of whichever kind wrote it. Throws FileError, also where no kind known to
/// this program did.
SavedModel open_model(const std::filesystem::path& path);
/// Of the held-out views, as they were judged when it was saved; NaN where none was.
double held_out_psnr_db(const SavedModel& model);
/// Not known where nothing was noted: no view was held out, or too few. Throws FileError.
ErrorCalibration calibration_of(const SavedModel& model, const std::filesystem::path& path);
/// Throws FileError where the model does not say.
ModelOrigin origin_of(const SavedModel& model, const std::filesystem::path& path);

}  // namespace sheen
