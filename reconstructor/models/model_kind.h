// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "common/capture/rig_motion.h"
#include "reconstructor/models/model_settings.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/models/model_stream.h"

namespace sheen {

class ModelDrawer;
struct DrawerOptions;

/// Takes a model that is being opened: each time as much of it as is there.
using ShowModel = std::function<void(std::shared_ptr<const ModelSnapshot>)>;

/// A kind of model: what the scene's configuration chooses, what a saved model was written by, what the window draws
/// it with. Each has one object, in its own folder; `model_kinds` lists them.
class ModelKind {
 public:
  virtual ~ModelKind() = default;
  virtual const char* name() const = 0;   ///< in scene files and reports: "surface_light_field"
  virtual const char* title() const = 0;  ///< for a person: "surface light field"
  /// What moves between the images that it is a model of: what `model = "auto"` chooses by. What stands still for it
  /// may not move.
  virtual RigMotion motion() const { return {.camera = Motion::kMoves, .light = Motion::kStill}; }
  virtual const char* file_format() const = 0;  ///< "format" in a saved model's model.json
  virtual std::unique_ptr<ModelSettings> default_settings() const = 0;
  /// Opens what `ModelSnapshot::save` wrote: it renders as the one that was saved, bit for bit. Throws FileError that
  /// names file and part where one is missing or broken.
  virtual std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& path) const = 0;
  /// Opens it before a person's eyes: what can be seen soon is shown first, all on one mesh; last what `load` gives.
  virtual void open(const std::filesystem::path& path, const ShowModel& show) const { show(load(path)); }
  /// Whether `ModelSnapshot::compressed` has a smaller form: one file.
  virtual bool compresses() const { return false; }
  /// Saved models that are one file: whether a file that begins so is one of them.
  virtual bool reads_file([[maybe_unused]] std::string_view start) const { return false; }
  /// What is noted in a file that `reads_file` knows, and notes something else. Throws FileError.
  virtual ModelMetadata file_metadata([[maybe_unused]] const std::filesystem::path& file) const { return {}; }
  virtual void set_file_metadata([[maybe_unused]] const std::filesystem::path& file,
                                 [[maybe_unused]] const ModelMetadata& metadata) const {}
  /// Null where no desk can draw such a model itself.
  virtual std::unique_ptr<ModelStream> make_stream() const { return nullptr; }
  /// With an OpenGL context current. Throws DeviceError.
  virtual std::unique_ptr<ModelDrawer> make_drawer(const DrawerOptions& options) const = 0;
};

}  // namespace sheen
