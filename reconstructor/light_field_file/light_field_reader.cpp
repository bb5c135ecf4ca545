// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/light_field_reader.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "common/base/errors.h"
#include "reconstructor/coding/difference_coding.h"
#include "reconstructor/light_field_file/json_parts.h"
#include "reconstructor/light_field_file/mesh_coding.h"
#include "reconstructor/light_field_file/resolution_coding.h"
#include "reconstructor/light_field_file/state_coding.h"
#include "reconstructor/light_field_file/vertex_coding.h"

namespace sheen {
namespace {

using Json = nlohmann::json;

// No more memory than the size of a file makes likely.
constexpr std::size_t kMostSamples = std::size_t{1} << 28, kSamplesPerByte = 4000;
constexpr std::size_t kMostPatchTriangles = 256;

/// Before the layers behind the first one.
constexpr std::string_view kFirstChunks[] = {"META", "DESC", "MESH", "RESO", "EYES", "VERT", "STEP", "L000", "STAT"};
constexpr std::size_t kChunksOfAPicture = 8;  ///< without which there is none

/// Little-endian 32-bit numbers, x y z each.
std::vector<GridMesh::Point> decode_eyes(std::string_view bytes, std::size_t cameras) {
  std::vector<GridMesh::Point> eyes(cameras);
  if (bytes.size() != cameras * sizeof(GridMesh::Point)) throw std::runtime_error("does not hold a place per camera");
  std::memcpy(eyes.data(), bytes.data(), bytes.size());
  return eyes;
}

}  // namespace

LightFieldReader::LightFieldReader(std::string file, ForEach for_each)
    : file_(std::move(file)), for_each_(std::move(for_each)) {}

std::string LightFieldReader::next_chunk() const {
  if (chunks_read_ < std::size(kFirstChunks)) return std::string(kFirstChunks[chunks_read_]);
  return layer_name(static_cast<int>(chunks_read_ - std::size(kFirstChunks)) + 1);
}

void LightFieldReader::fail(const std::string& what) const {
  throw FileError(file_, "chunk \"" + next_chunk() + "\" " + what);
}

std::optional<std::string> LightFieldReader::read_next(std::string_view bytes) {
  const std::string name = next_chunk();
  if (name == layer_name(description_.layers)) return std::nullopt;
  file_bytes_ = bytes.size();
  Chunks chunks(kLightFieldFile, bytes, file_, position_);
  const auto contents = chunks.next(name);
  if (!contents) return std::nullopt;
  try {
    decode(name, *contents);
  } catch (const FileError&) {
    throw;
  } catch (const Json::exception& error) {
    fail(std::string("is not valid: ") + error.what());
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  } catch (const std::runtime_error& error) {
    fail(error.what());
  }
  position_ = chunks.position();
  ++chunks_read_;
  return name;
}

void LightFieldReader::decode(std::string_view name, std::string_view bytes) {
  CompactModel& model = quantised_.model;
  if (name == "DESC") {
    read_description(bytes);
  } else if (name == "MESH") {
    model.grid = std::make_shared<const GridMesh>(decode_mesh(bytes));
    Mesh mesh = model.grid->mesh();
    mesh.origin = description_.origin;
    model.mesh = std::make_shared<Mesh>(std::move(mesh));
  } else if (name == "RESO") {
    std::vector<std::uint8_t> resolutions = decode_resolutions(*model.grid, bytes);
    check_samples(resolutions);
    model.maps = std::make_shared<MapLayout>(std::move(resolutions));
  } else if (name == "EYES") {
    model.eyes = decode_eyes(bytes, model.cameras.size());
  } else if (name == "VERT") {
    decode_vertices(bytes, model);
    find_sources(model);
    model.shapes = cut_into_patches(*model.mesh, *model.maps, {.triangles = description_.patch_triangles});
  } else if (name == "STEP") {
    begin_patches(bytes);
  } else if (name == "STAT") {
    decode_states(bytes, model);
  } else if (name.front() == 'L') {
    const int layer =
        chunks_read_ < std::size(kFirstChunks) ? 0 : static_cast<int>(chunks_read_ - std::size(kFirstChunks)) + 1;
    decode_layer(quantised_.layout.patches, bytes, quantised_.patches, layer, layer_models_);
  }
}

void LightFieldReader::check_samples(const std::vector<std::uint8_t>& resolutions) {
  std::size_t samples = 0;
  for (const std::uint8_t resolution : resolutions) samples += static_cast<std::size_t>(lattice_samples(resolution));
  if (samples > kMostSamples || samples > kSamplesPerByte * file_bytes_)
    fail("asks for more samples than such a file can hold");
}

void LightFieldReader::begin_patches(std::string_view bytes) {
  CompactModel& model = quantised_.model;
  const std::size_t patches = model.shapes.patches.size();
  const auto steps = decode_differences<std::int8_t>(bytes, patches, -kFurthestPatchStep, kFurthestPatchStep);
  quantised_.layout = file_layout(model, description_.step, steps, for_each_);
  model.patches.resize(patches);
  for (std::size_t i = 0; i < patches; ++i)
    model.patches[i].state.assign(model.shapes.patches[i].samples, SampleState::kMeasured);
  quantised_.patches.resize(patches);
}

void LightFieldReader::read_description(std::string_view bytes) {
  CompactModel& model = quantised_.model;
  const Json json = Json::parse(unpacked(bytes));
  Description& description = description_;
  description = {json.at("step"), json.at("layers"), json.at("patch_triangles"), Eigen::Vector3d::Zero(), {}};
  if (!(description.step > 0 && description.step < 1e6f) || description.layers < kMeanLayers ||
      description.layers > kMostLayers || description.patch_triangles > kMostPatchTriangles)
    throw std::runtime_error("holds a step or layers that cannot be");
  description.layer_squares =
      json_numbers(json.at("layer_squares"), "layer_squares: ", json.at("layer_squares").size());
  if (description.layer_squares.size() != static_cast<std::size_t>(description.layers) ||
      std::any_of(description.layer_squares.begin(), description.layer_squares.end(), [](double s) { return s < 0; }))
    throw std::runtime_error("does not say what each layer adds");
  model.brightest = json.at("brightest");
  if (!(model.brightest >= 0 && model.brightest <= CompactModel::kMostBrightest))
    throw std::runtime_error("holds a brightest colour that cannot be");
  const Json& kernels = json.at("kernels");
  if (!kernels.is_array() || kernels.size() > 255) throw std::runtime_error("holds no list of kernels");
  for (const Json& kernel : kernels) model.kernels.push_back(kernel_from_json(kernel));
  model.reflection = reflection_from_json(json.at("reflection"));
  model.exposure = exposure_from_json(json.at("exposure"));
  model.cameras = cameras_from_json(json.at("cameras"));
  if (model.cameras.size() > UINT16_MAX) throw std::runtime_error("holds too many cameras");
  if (const auto origin = json.find("origin"); origin != json.end())
    description.origin = Eigen::Map<const Eigen::Vector3d>(json_numbers(*origin, "origin ", 3).data());
}

void LightFieldReader::note_missing() {
  CompactModel& model = quantised_.model;
  const auto layers_read =
      static_cast<int>(std::max(chunks_read_, std::size(kFirstChunks)) - std::size(kFirstChunks)) + 1;
  model.layers = description_.layers;
  model.missing_layers = description_.layers - layers_read;
  model.missing_square =
      std::accumulate(description_.layer_squares.begin() + layers_read, description_.layer_squares.end(), 0.0);
}

QuantisedModel LightFieldReader::finish() && {
  if (chunks_read_ < kChunksOfAPicture) fail("is missing: the file was cut short");
  note_missing();
  return std::move(quantised_);
}

}  // namespace sheen
