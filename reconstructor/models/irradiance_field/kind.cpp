// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/kind.h"

#include "common/base/files.h"
#include "reconstructor/irradiance_field_file/field_reader.h"
#include "reconstructor/models/irradiance_field/field_file.h"
#include "reconstructor/models/irradiance_field/gl/field_drawer.h"
#include "reconstructor/models/irradiance_field/irradiance_field_options.h"

namespace sheen {
namespace {

class IrradianceFieldKind : public ModelKind {
 public:
  const char* name() const override { return IrradianceFieldOptions::kName; }
  const char* title() const override { return "irradiance field"; }
  RigMotion motion() const override { return {.camera = Motion::kStill, .light = Motion::kMoves}; }
  const char* file_format() const override { return kFieldFormat; }
  std::unique_ptr<ModelSettings> default_settings() const override {
    return std::make_unique<IrradianceFieldOptions>();
  }
  std::shared_ptr<const ModelSnapshot> load(const std::filesystem::path& path) const override {
    return load_field(path);
  }
  bool compresses() const override { return true; }
  bool reads_file(std::string_view start) const override { return is_field_file(start); }
  ModelMetadata file_metadata(const std::filesystem::path& file) const override { return field_file_metadata(file); }
  void set_file_metadata(const std::filesystem::path& file, const ModelMetadata& metadata) const override {
    save_field_file(file, read_file(file), metadata);
  }
  std::unique_ptr<ModelDrawer> make_drawer(const DrawerOptions&) const override {
    return std::make_unique<FieldDrawer>();
  }
};

}  // namespace

const ModelKind& irradiance_field_kind() {
  static const IrradianceFieldKind kind;
  return kind;
}

}  // namespace sheen
