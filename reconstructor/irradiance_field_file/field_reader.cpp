// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/irradiance_field_file/field_reader.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "reconstructor/coding/camera_json.h"
#include "reconstructor/irradiance_field_file/field_format.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

// An image of more lights than this, or of more pixels on a side, is not asked for by anybody honest.
constexpr int kMostLights = 4096, kMostSide = 1 << 15;
// No more memory than the size of a file makes likely.
constexpr std::size_t kMostCoefficients = std::size_t{1} << 28, kCoefficientsPerByte = 20000;

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
  return start.starts_with(kFieldFileFormat.magic);
}

StoredField read_field(std::string_view bytes, const std::string& file) {
  Chunks chunks(kFieldFileFormat, bytes, file);
  StoredField stored;
  QuantisedField& field = stored.field;
  chunks.required("META");
  chunks.read("DESC", [&](std::string_view chunk) { read_description(chunk, stored.scene, field); });
  const std::size_t pixels = tile_grid(field.size).tiles() * kTilePixels;
  for (std::size_t c = 0; c < kMapChunks.size(); ++c)
    chunks.read(kMapChunks[c], [&](std::string_view map) {
      const std::size_t coefs = pixels * field.components[c].terms();
      if (coefs > kMostCoefficients || coefs > kCoefficientsPerByte * (map.size() + 1))
        throw std::invalid_argument("asks for larger maps than such a file can hold");
      decode_component(map, field, c);
    });
  return stored;
}

}  // namespace sheen
