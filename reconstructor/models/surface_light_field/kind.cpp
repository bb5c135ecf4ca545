// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/kind.h"

#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/files/model_layout.h"
#include "reconstructor/models/surface_light_field/gl/light_field_renderer.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {
namespace {

class SurfaceLightFieldKind : public ModelKind {
 public:
  const char* name() const override { return SurfaceLightFieldOptions::kName; }
  const char* title() const override { return "surface light field"; }
  const char* file_format() const override { return kModelFormat; }
  std::unique_ptr<ModelSettings> default_settings() const override {
    return std::make_unique<SurfaceLightFieldOptions>();
  }
  std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& folder) const override {
    return load_model(folder);
  }
  std::unique_ptr<ModelDrawer> make_drawer(const DrawerOptions& options) const override {
    return std::make_unique<LightFieldRenderer>(options);
  }
};

}  // namespace

const ModelKind& surface_light_field_kind() {
  static const SurfaceLightFieldKind kind;
  return kind;
}

}  // namespace sheen
