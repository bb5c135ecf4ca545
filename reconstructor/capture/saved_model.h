// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/base/progress.h"
#include "reconstructor/capture/reconstruction.h"
#include "reconstructor/evaluation/error_calibration.h"
#include "reconstructor/models/model_kind.h"

namespace sheen {

/// Every saved model that is a folder has it: {"format": ..., "metadata": {...}, ...}.
inline constexpr const char* kModelJsonFile = "model.json";
/// In a session's folder: the model that `serve` saves.
inline constexpr const char* kSessionModel = "model";

/// Whether a model can be saved at `path`, as one file or as a folder, asked before the work: also where one of the
/// other form is, but not where there is anything else of it. Throws FileError that says why not.
void check_model_path(const std::filesystem::path& path, bool one_file);

/// What came of a model that was saved as one small file.
struct SmallFile {
  std::uintmax_t bytes = 0;
  double loss_db = 0;    ///< of the PSNR of its pictures
  bool as_asked = true;  ///< it loses no more than it may
};
/// Saves a model of the reconstruction, unseen parts filled with a guess, and notes its settings and what became of
/// every capture: as one small file, judged on the held-out views, or without `size` as it is, in a folder. `source`
/// says where the images came from. Until the new model is whole, an older one stays. The model is let go of as soon as
/// it is not needed.
std::optional<SmallFile> save_reconstruction(const Reconstruction& reconstruction,
                                             std::shared_ptr<const ModelSnapshot> model,
                                             const std::filesystem::path& path, const std::string& source,
                                             std::optional<CompressionTarget> size, const StepsDone& progress = {});

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
/// Of a saved model, a folder or a file. Throws FileError where no kind known to this program wrote it.
const ModelKind& kind_of_model(const std::filesystem::path& path);
/// Opens a saved model, a folder or a file, of whichever kind wrote it. Throws FileError, also where no kind known to
/// this program did.
SavedModel open_model(const std::filesystem::path& path);
/// Of a saved model's file, or of the files in its folder.
std::uintmax_t saved_bytes(const std::filesystem::path& path);
/// Of the held-out views, as they were judged when it was saved; NaN where none was.
double held_out_psnr_db(const SavedModel& model);
/// Not known where nothing was noted: no view was held out, or too few. Throws FileError.
ErrorCalibration calibration_of(const SavedModel& model, const std::filesystem::path& path);
/// Throws FileError where the model does not say.
ModelOrigin origin_of(const SavedModel& model, const std::filesystem::path& path);

}  // namespace sheen
