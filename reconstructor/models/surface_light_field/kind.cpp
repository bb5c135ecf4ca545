// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/kind.h"

#include "common/base/files.h"
#include "reconstructor/light_field_file/light_field_file.h"
#include "reconstructor/models/surface_light_field/files/compact_file.h"
#include "reconstructor/models/surface_light_field/files/model_files.h"
#include "reconstructor/models/surface_light_field/files/model_layout.h"
#include "reconstructor/models/surface_light_field/gl/light_field_renderer.h"
#include "reconstructor/models/surface_light_field/stream/light_field_stream.h"
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
  std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& path) const override {
    if (std::filesystem::is_directory(path)) return load_model(path);
    return load_compact(path);
  }
  void open(const std::filesystem::path& path, const ShowModel& show) const override {
    show(std::filesystem::is_directory(path) ? std::shared_ptr<const ModelSnapshot>(load_model(path, show))
                                             : load_compact(path, show));
  }
  bool compresses() const override { return true; }
  bool reads_file(std::string_view start) const override { return is_light_field_file(start); }
  ModelMetadata file_metadata(const std::filesystem::path& file) const override {
    return compact_metadata(read_file(file), file.string());
  }
  void set_file_metadata(const std::filesystem::path& file, const ModelMetadata& metadata) const override {
    save_compact(file, read_file(file), metadata);
  }
  std::unique_ptr<ModelStream> make_stream() const override { return std::make_unique<LightFieldStream>(); }
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
