// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "reconstructor/models/model_settings.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

class ModelDrawer;
struct DrawerOptions;

/// A kind of model: what the scene's configuration chooses, what a saved model was written by, what the window draws
/// it with. Each has one object, in its own folder; `model_kinds` lists them.
class ModelKind {
 public:
  virtual ~ModelKind() = default;
  virtual const char* name() const = 0;         ///< in scene files and reports: "surface_light_field"
  virtual const char* title() const = 0;        ///< for a person: "surface light field"
  virtual const char* file_format() const = 0;  ///< "format" in a saved model's model.json
  virtual std::unique_ptr<ModelSettings> default_settings() const = 0;
  /// Opens what `ModelSnapshot::save` wrote: it renders as the one that was saved, bit for bit. Throws FileError that
  /// names file and part where one is missing or broken.
  virtual std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& folder) const = 0;
  /// With an OpenGL context current. Throws DeviceError.
  virtual std::unique_ptr<ModelDrawer> make_drawer(const DrawerOptions& options) const = 0;
};

}  // namespace sheen
