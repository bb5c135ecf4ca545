// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/field_file.h"

#include <nlohmann/json.hpp>

#include "common/base/files.h"
#include "reconstructor/irradiance_field_file/field_format.h"
#include "reconstructor/irradiance_field_file/field_reader.h"
#include "reconstructor/models/irradiance_field/picture_plane.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr const char* kFieldFileName = "field.rif";

}  // namespace

std::shared_ptr<const IrradianceFieldSnapshot> decode_field(std::string_view bytes, const std::string& file,
                                                            bool in_one_file) {
  StoredField stored = read_field(bytes, file);
  auto plane = std::make_shared<const Mesh>(picture_plane(stored.scene.camera));
  return std::make_shared<IrradianceFieldSnapshot>(std::move(plane), std::move(stored.scene), std::move(stored.field),
                                                   1, in_one_file);
}

void save_field_file(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata) {
  write_file(file, with_notes(kFieldFileFormat, encoded, metadata, file.string()));
}

void save_field_folder(const std::filesystem::path& folder, std::string_view encoded, const ModelMetadata& metadata) {
  make_folder(folder);
  write_file(folder / kFieldFileName, encoded);
  write_file(folder / "model.json",
             OrderedJson{{"format", kFieldFormat}, {"field", kFieldFileName}, {"metadata", metadata}}.dump(
                 -1, ' ', false, Json::error_handler_t::replace) +
                 "\n");
}

std::shared_ptr<const IrradianceFieldSnapshot> load_field(const std::filesystem::path& path) {
  const bool folder = std::filesystem::is_directory(path);
  const std::filesystem::path file = folder ? path / kFieldFileName : path;
  return decode_field(read_file(file), file.string(), !folder);
}

ModelMetadata field_file_metadata(const std::filesystem::path& file) {
  return notes_of(kFieldFileFormat, read_file(file), file.string());
}

}  // namespace sheen
