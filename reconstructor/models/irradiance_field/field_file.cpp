// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/irradiance_field/field_file.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/coding/camera_json.h"
#include "reconstructor/coding/chunk_file.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

constexpr ChunkFormat kFormat{.magic = "sheenRIF", .version = 2, .title = "irradiance field"};
constexpr std::array<std::string_view, 3> kMapChunks{"MAP0", "MAP1", "MAP2"};
constexpr const char* kFieldFileName = "field.rif";
// No more memory than the size of a file makes likely.
constexpr std::size_t kMostCoefficients = std::size_t{1} << 28, kCoefficientsPerByte = 20000;

OrderedJson describe(const LitScene& scene, const QuantisedField& field) {
  return {{"step", field.step},
          {"camera", cameras_to_json({scene.camera})},
          {"light_kind", static_cast<int>(scene.kind)},
          {"lights", std::vector<double>(scene.lights.data(), scene.lights.data() + scene.lights.size())},
          {"kernel",
           {{"shape", static_cast<int>(scene.kernel.shape)},
            {"drift_degree", scene.kernel.drift_degree},
            {"depth", scene.kernel.depth}}},
          {"error", scene.error},
          {"terms", {field.components[0].terms(), field.components[1].terms(), field.components[2].terms()}}};
}

/// The scene and the field as far as the description says them. Throws std::exception.
void read_description(std::string_view bytes, LitScene& scene, QuantisedField& field) {
  const Json json = Json::parse(unpacked(bytes));
  const std::vector<PosedCamera> cameras = cameras_from_json(json.at("camera"));
  if (cameras.size() != 1) throw std::invalid_argument("must have one camera");
  scene.camera = cameras[0];
  const std::vector<double> lights = json_numbers(json.at("lights"), "lights ", json.at("lights").size());
  if (lights.empty() || lights.size() % 3 != 0 || lights.size() > 3 * std::size_t{kMostLights})
    throw std::invalid_argument("lights must be x y z each, 1 to " + std::to_string(kMostLights));
  scene.lights = Eigen::Map<const Eigen::Matrix3Xd>(lights.data(), 3, static_cast<Eigen::Index>(lights.size() / 3));
  const int kind = json.at("light_kind");
  if (kind != static_cast<int>(LightKind::kDirectional) && kind != static_cast<int>(LightKind::kPoint))
    throw std::invalid_argument("light_kind is none that is known");
  scene.kind = static_cast<LightKind>(kind);
  const Json& kernel = json.at("kernel");
  const int shape = kernel.at("shape");
  if (shape < 0 || shape > static_cast<int>(PointKernelShape::kCubic))
    throw std::invalid_argument("kernel is none that is known");
  scene.kernel = {static_cast<PointKernelShape>(shape), kernel.at("drift_degree"), kernel.at("depth")};
  if (scene.kernel.drift_degree < 1 || scene.kernel.drift_degree > 3 ||
      !(scene.kernel.depth >= 0 && scene.kernel.depth <= 100))
    throw std::invalid_argument("kernel has a drift or a depth that cannot be");
  scene.error = json.at("error");
  field.step = json.at("step");
  if (!(field.step > 0 && field.step < 1e6f) || !(scene.error >= 0 && scene.error < 1e6))
    throw std::invalid_argument("holds a step or an error that cannot be");
  const Camera& camera = scene.camera.camera;
  if (camera.has_distortion() || camera.width > kMostSide || camera.height > kMostSide)
    throw std::invalid_argument("has a camera whose pictures are no such field");
  field.size = {camera.width, camera.height};
  field.lights = static_cast<int>(scene.lights.cols());
  const Json& terms = json.at("terms");
  if (!terms.is_array() || terms.size() != kMapChunks.size())
    throw std::invalid_argument("terms must be three numbers");
  for (std::size_t c = 0; c < kMapChunks.size(); ++c) {
    const int count = terms.at(c);
    if (count < 0 || count > field.lights) throw std::invalid_argument("terms must be 0 to the number of lights");
    field.components[c].bits.resize(static_cast<std::size_t>(count));
  }
}

}  // namespace

bool is_field_file(std::string_view start) {
  return start.starts_with(kFormat.magic);
}

std::string encode_field(const LitScene& scene, const QuantisedField& field) {
  std::string out = start_of_file(kFormat, {});
  append_chunk(out, "DESC", packed(describe(scene, field).dump()));
  std::array<std::string, kMapChunks.size()> maps;
  tbb::parallel_for(std::size_t{0}, maps.size(), [&](std::size_t c) { maps[c] = encode_component(field, c); });
  for (std::size_t c = 0; c < maps.size(); ++c) append_chunk(out, kMapChunks[c], maps[c]);
  return out;
}

std::shared_ptr<const IrradianceFieldSnapshot> decode_field(std::string_view bytes, const std::string& file,
                                                            bool in_one_file) {
  Chunks chunks(kFormat, bytes, file);
  LitScene scene;
  QuantisedField field;
  chunks.required("META");
  chunks.read("DESC", [&](std::string_view chunk) { read_description(chunk, scene, field); });
  const std::size_t pixels = tile_grid(field.size).tiles() * kTilePixels;
  for (std::size_t c = 0; c < kMapChunks.size(); ++c)
    chunks.read(kMapChunks[c], [&](std::string_view map) {
      const std::size_t coefs = pixels * field.components[c].terms();
      if (coefs > kMostCoefficients || coefs > kCoefficientsPerByte * (map.size() + 1))
        throw std::invalid_argument("asks for larger maps than such a file can hold");
      decode_component(map, field, c);
    });
  auto plane = std::make_shared<const Mesh>(picture_plane(scene.camera));
  return std::make_shared<IrradianceFieldSnapshot>(std::move(plane), std::move(scene), std::move(field), 1,
                                                   in_one_file);
}

void save_field_file(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata) {
  write_file(file, with_notes(kFormat, encoded, metadata, file.string()));
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
  return notes_of(kFormat, read_file(file), file.string());
}

}  // namespace sheen
