// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/light_field_file.h"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "common/base/errors.h"
#include "reconstructor/coding/difference_coding.h"
#include "reconstructor/light_field_file/edge_blending.h"
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

struct Description {
  float step = 0;
  int layers = 0;
  std::size_t patch_triangles = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the mesh
  std::vector<double> layer_squares;                 ///< what each layer adds to pictures: mean square, in grey levels
};

Description read_description(std::string_view bytes, CompactModel& model) {
  const Json json = Json::parse(unpacked(bytes));
  Description description{json.at("step"), json.at("layers"), json.at("patch_triangles"), Eigen::Vector3d::Zero(), {}};
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
  return description;
}

/// Little-endian 32-bit numbers, x y z each.
std::vector<GridMesh::Point> decode_eyes(std::string_view bytes, std::size_t cameras) {
  std::vector<GridMesh::Point> eyes(cameras);
  if (bytes.size() != cameras * sizeof(GridMesh::Point)) throw std::runtime_error("does not hold a place per camera");
  std::memcpy(eyes.data(), bytes.data(), bytes.size());
  return eyes;
}

/// The layers behind the first one, as far as they are there: their number with it.
int decode_further_layers(Chunks& chunks, int layers, QuantisedModel& quantised, LayerModels& models) {
  for (int layer = 1; layer < layers; ++layer) {
    const std::string name = layer_name(layer);
    const auto bytes = chunks.next(name);
    if (!bytes) return layer;
    try {
      decode_layer(quantised.layout.patches, *bytes, quantised.patches, layer, models);
    } catch (const std::runtime_error& error) {
      chunks.fail(name, error.what());
    }
  }
  return layers;
}

void note_missing(const Description& description, int layers_read, CompactModel& model) {
  model.layers = description.layers;
  model.missing_layers = description.layers - layers_read;
  model.missing_square =
      std::accumulate(description.layer_squares.begin() + layers_read, description.layer_squares.end(), 0.0);
}

}  // namespace

bool is_light_field_file(std::string_view start) {
  return start.starts_with(kLightFieldFile.magic);
}

/// A patch at a time: all terms at once in floating point would be the largest part of opening it.
CompactModel QuantisedModel::dequantised(const ForEach& for_each) && {
  const EdgeBlending blending(model);
  for_each(patches.size(), [&](std::size_t i) {
    Patch patch = dequantise(patches[i], layout.resolutions[i], layout.plans[i], layout.steps[i]);
    patches[i] = {};
    patch.state = std::move(model.patches[i].state);
    blending.blend_terms(i, patch.basis.exact());
    patch.basis = packed_terms(patch.basis.exact(), Eigen::VectorXf::Ones(patch.basis.cols()));
    model.patches[i] = std::move(patch);
  });
  blending.blend_means(model);
  return std::move(model);
}

QuantisedModel read_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show) {
  Chunks chunks(kLightFieldFile, bytes, file);
  QuantisedModel quantised;
  CompactModel& model = quantised.model;
  std::string_view reading = "META";
  try {
    chunks.required(reading);
    reading = "DESC";
    const Description description = read_description(chunks.required(reading), model);
    reading = "MESH";
    model.grid = std::make_shared<const GridMesh>(decode_mesh(chunks.required(reading)));
    Mesh mesh = model.grid->mesh();
    mesh.origin = description.origin;
    model.mesh = std::make_shared<Mesh>(std::move(mesh));
    if (show.mesh) show.mesh(model);
    reading = "RESO";
    std::vector<std::uint8_t> resolutions = decode_resolutions(*model.grid, chunks.required(reading));
    std::size_t samples = 0;
    for (const std::uint8_t resolution : resolutions) samples += static_cast<std::size_t>(lattice_samples(resolution));
    if (samples > kMostSamples || samples > kSamplesPerByte * bytes.size())
      chunks.fail(reading, "asks for more samples than such a file can hold");
    model.maps = std::make_shared<MapLayout>(std::move(resolutions));
    reading = "EYES";
    model.eyes = decode_eyes(chunks.required(reading), model.cameras.size());
    reading = "VERT";
    decode_vertices(chunks.required(reading), model);
    find_sources(model);
    model.shapes = cut_into_patches(*model.mesh, *model.maps, {.triangles = description.patch_triangles});
    const std::size_t patches = model.shapes.patches.size();
    reading = "STEP";
    const auto steps =
        decode_differences<std::int8_t>(chunks.required(reading), patches, -kFurthestPatchStep, kFurthestPatchStep);
    quantised.layout = file_layout(model, description.step, steps, for_each);
    model.patches.resize(patches);
    for (std::size_t i = 0; i < patches; ++i)
      model.patches[i].state.assign(model.shapes.patches[i].samples, SampleState::kMeasured);
    quantised.patches.resize(patches);
    reading = "L000";
    LayerModels models;
    decode_layer(quantised.layout.patches, chunks.required(reading), quantised.patches, 0, models);
    int layers_read = 1;
    reading = "STAT";
    if (const auto states = chunks.next(reading)) {
      decode_states(*states, model);
      if (show.smooth) show.smooth(quantised);
      layers_read = decode_further_layers(chunks, description.layers, quantised, models);
    }
    note_missing(description, layers_read, model);
  } catch (const FileError&) {
    throw;
  } catch (const Json::exception& error) {
    chunks.fail(reading, std::string("is not valid: ") + error.what());
  } catch (const std::invalid_argument& error) {
    chunks.fail(reading, error.what());
  } catch (const std::runtime_error& error) {
    chunks.fail(reading, error.what());
  }
  return quantised;
}

CompactModel decode_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show) {
  return read_light_field(bytes, file, for_each, show).dequantised(for_each);
}

}  // namespace sheen
