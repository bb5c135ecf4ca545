// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/files/compact_file.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstring>
#include <future>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/format.h"
#include "reconstructor/coding/chunk_file.h"
#include "reconstructor/coding/difference_coding.h"
#include "reconstructor/models/surface_light_field/compact/edge_blending.h"
#include "reconstructor/models/surface_light_field/compact/grid_geometry.h"
#include "reconstructor/models/surface_light_field/compact/lattice_spectrum.h"
#include "reconstructor/models/surface_light_field/compact/mesh_coding.h"
#include "reconstructor/models/surface_light_field/compact/patch_coding.h"
#include "reconstructor/models/surface_light_field/compact/patch_steps.h"
#include "reconstructor/models/surface_light_field/compact/resolution_coding.h"
#include "reconstructor/models/surface_light_field/compact/state_coding.h"
#include "reconstructor/models/surface_light_field/compact/vertex_coding.h"
#include "reconstructor/models/surface_light_field/files/json_parts.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

// What version 2 holds was read by floating point: each build of the program reads it a little differently.
constexpr std::string_view kOlder =
    "which other builds do not read alike; build it again from its session or photographs";
constexpr ChunkFormat kFormat{.magic = "sheenSLF", .version = 3, .title = "surface light field", .older = kOlder};
// No more memory than the size of a file makes likely.
constexpr std::size_t kMostSamples = std::size_t{1} << 28, kSamplesPerByte = 4000;
constexpr int kMostLayers = 128;
constexpr std::size_t kMostPatchTriangles = 256;

OrderedJson description_of(const CompactModel& model, float step, int layers) {
  OrderedJson kernels = OrderedJson::array();
  for (const ViewKernel& kernel : model.kernels) kernels.push_back(kernel_to_json(kernel));
  OrderedJson json{{"step", step},
                   {"patch_triangles", model.patch_triangles},
                   {"layers", layers},
                   {"kernels", kernels},
                   {"reflection", reflection_to_json(model.reflection.get())},
                   {"exposure", exposure_to_json(model.exposure)},
                   {"cameras", cameras_to_json(model.cameras)}};
  if (const Eigen::Vector3d& origin = model.mesh->origin; !origin.isZero(0))
    json["origin"] = {origin.x(), origin.y(), origin.z()};
  return json;
}

struct Description {
  float step = 0;
  int layers = 0;
  std::size_t patch_triangles = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the mesh
};

Description read_description(std::string_view bytes, CompactModel& model) {
  const Json json = Json::parse(unpacked(bytes));
  Description description{json.at("step"), json.at("layers"), json.at("patch_triangles"), Eigen::Vector3d::Zero()};
  if (!(description.step > 0 && description.step < 1e6f) || description.layers < kMeanLayers ||
      description.layers > kMostLayers || description.patch_triangles > kMostPatchTriangles)
    throw std::runtime_error("holds a step or layers that cannot be");
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
std::string encode_eyes(const std::vector<GridMesh::Point>& eyes) {
  return {reinterpret_cast<const char*>(eyes.data()), eyes.size() * sizeof(GridMesh::Point)};
}

std::vector<GridMesh::Point> decode_eyes(std::string_view bytes, std::size_t cameras) {
  std::vector<GridMesh::Point> eyes(cameras);
  if (bytes.size() != cameras * sizeof(GridMesh::Point)) throw std::runtime_error("does not hold a place per camera");
  std::memcpy(eyes.data(), bytes.data(), bytes.size());
  return eyes;
}

ViewHaar haar_of(const CompactModel& model) {
  return {model.eyes, box_centre(*model.grid)};
}

/// How each patch is laid out, and how its coefficients are transformed.
struct Layout {
  PatchLayout patches;
  std::vector<ViewHaar::Plan> plans;          ///< per patch
  std::vector<std::vector<int>> resolutions;  ///< per patch: of its triangles
  std::vector<float> steps;                   ///< per patch
};

Layout layout_of(const CompactModel& model, float step, const std::vector<std::int8_t>& patch_steps) {
  const ViewHaar haar = haar_of(model);
  const std::size_t patches = model.shapes.patches.size();
  Layout layout;
  layout.patches.images.resize(patches);
  layout.patches.tile_sizes.resize(patches);
  layout.patches.haar_parent.resize(patches);
  layout.plans.resize(patches);
  layout.resolutions.resize(patches);
  for (const std::int8_t patch_step : patch_steps) layout.steps.push_back(step_of_patch(step, patch_step));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, patches, 64), [&](const auto& range) {
    for (std::size_t t = range.begin(); t < range.end(); ++t) {
      const std::vector<std::uint16_t> images = patch_images(model, model.shapes.patches[t]);
      layout.plans[t] = haar.plan(images);
      layout.patches.images[t] = images.size();
      layout.patches.haar_parent[t].resize(images.size());
      for (const ViewHaar::Plan::Step& merge : layout.plans[t].steps)
        layout.patches.haar_parent[t][static_cast<std::size_t>(merge.coefficient)] =
            static_cast<std::uint16_t>(merge.parent);
      for (const std::uint32_t triangle : model.shapes.patches[t].triangles) {
        layout.resolutions[t].push_back(model.maps->resolution(triangle));
        for (const LatticeSpectrum::Tile& tile : lattice_spectrum(layout.resolutions[t].back()).tiles)
          layout.patches.tile_sizes[t].push_back(static_cast<int>(tile.samples.size()));
      }
    }
  });
  return layout;
}

std::string layer_name(int layer) {
  return format("L%03d", layer);
}

/// The model's maps and coefficients, of `patches`, which are let go of; its states are there. All of its terms at once
/// in floating point would be the largest part of opening it.
void dequantise_all(CompactModel& model, std::vector<QuantisedPatch> patches, const Layout& layout) {
  const EdgeBlending blending(model);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, patches.size(), 16), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      Patch patch = dequantise(patches[i], layout.resolutions[i], layout.plans[i], layout.steps[i]);
      patches[i] = {};
      patch.state = std::move(model.patches[i].state);
      blending.blend_terms(i, patch.basis.exact());
      patch.basis = packed_terms(patch.basis.exact(), Eigen::VectorXf::Ones(patch.basis.cols()));
      model.patches[i] = std::move(patch);
    }
  });
  blending.blend_means(model);
}

}  // namespace

bool is_compact(std::string_view start) {
  return start.starts_with(kFormat.magic);
}

std::string encode_compact(CompactModel& model, const CanonicalMesh& mesh, float step, const Rounding& rounding) {
  const std::string vertices = encode_vertices(model);  // first: reliabilities are those of the file from here on
  const std::vector<std::int8_t> patch_steps = choose_patch_steps(model);
  const Layout layout = layout_of(model, step, patch_steps);
  std::vector<QuantisedPatch> patches(model.patches.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, patches.size(), 16), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i)
      patches[i] = quantise(model.patches[i], layout.resolutions[i], layout.plans[i], layout.steps[i], rounding);
  });
  std::vector<std::uint8_t> resolutions;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t)
    resolutions.push_back(static_cast<std::uint8_t>(model.maps->resolution(t)));
  const int layers = layer_count(patches);

  std::string out = start_of_file(kFormat, {});
  append_chunk(out, "DESC", packed(description_of(model, step, layers).dump()));
  append_chunk(out, "MESH", mesh.bytes);
  append_chunk(out, "RESO", encode_resolutions(mesh.grid, resolutions));
  append_chunk(out, "EYES", encode_eyes(model.eyes));
  append_chunk(out, "VERT", vertices);
  append_chunk(out, "STEP", encode_differences(patch_steps));
  LayerModels models;
  append_chunk(out, layer_name(0), encode_layer(layout.patches, patches, 0, models));
  append_chunk(out, "STAT", encode_states(model));
  for (int layer = 1; layer < layers; ++layer)
    append_chunk(out, layer_name(layer), encode_layer(layout.patches, patches, layer, models));
  return out;
}

CompactModel decode_compact(std::string_view bytes, const std::string& file, const ShowModel& show) {
  Chunks chunks(kFormat, bytes, file);
  CompactModel model;
  std::string_view reading = "META";
  try {
    chunks.required(reading);
    reading = "DESC";
    const Description description = read_description(chunks.required(reading), model);
    reading = "MESH";
    const auto grid = std::make_shared<const GridMesh>(decode_mesh(chunks.required(reading)));
    model.grid = grid;
    Mesh mesh = grid->mesh();
    mesh.origin = description.origin;
    model.mesh = std::make_shared<Mesh>(std::move(mesh));
    if (show) show(bare_mesh(model.mesh, model.cameras));
    reading = "RESO";
    std::vector<std::uint8_t> resolutions = decode_resolutions(*grid, chunks.required(reading));
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
    reading = "STEP";
    const Layout layout =
        layout_of(model, description.step,
                  decode_differences<std::int8_t>(chunks.required(reading), model.shapes.patches.size(),
                                                  -kFurthestPatchStep, kFurthestPatchStep));
    std::future<void> shown;  // the smooth part: made ready beside the decoding, which is serial
    model.patches.resize(model.shapes.patches.size());
    for (std::size_t i = 0; i < model.patches.size(); ++i)
      model.patches[i].state.assign(model.shapes.patches[i].samples, SampleState::kMeasured);
    std::vector<QuantisedPatch> patches(model.patches.size());
    reading = "L000";
    LayerModels models;
    decode_layer(layout.patches, chunks.required(reading), patches, 0, models);
    reading = "STAT";
    if (const auto states = chunks.next(reading)) {
      decode_states(*states, model);
      if (show)
        shown = std::async(std::launch::async, [&, coarse = model, smooth = patches]() mutable {
          dequantise_all(coarse, std::move(smooth), layout);
          show(std::make_shared<CompactLightField>(std::move(coarse), nullptr));
        });
      for (int layer = 1; layer < description.layers; ++layer) {
        const std::string name = layer_name(layer);
        const auto layer_bytes = chunks.next(name);
        if (!layer_bytes) break;
        try {
          decode_layer(layout.patches, *layer_bytes, patches, layer, models);
        } catch (const std::runtime_error& error) {
          chunks.fail(name, error.what());
        }
      }
    }
    dequantise_all(model, std::move(patches), layout);
    if (shown.valid()) shown.get();
  } catch (const FileError&) {
    throw;
  } catch (const Json::exception& error) {
    chunks.fail(reading, std::string("is not valid: ") + error.what());
  } catch (const std::invalid_argument& error) {
    chunks.fail(reading, error.what());
  } catch (const std::runtime_error& error) {
    chunks.fail(reading, error.what());
  }
  return model;
}

void save_compact(const std::filesystem::path& file, std::string_view encoded, const ModelMetadata& metadata) {
  write_file(file, with_notes(kFormat, encoded, metadata, file.string()));
}

std::shared_ptr<const CompactLightField> load_compact(const std::filesystem::path& file, const ShowModel& show) {
  auto bytes = std::make_shared<const std::string>(read_file(file));
  CompactModel model = decode_compact(*bytes, file.string(), show);
  return std::make_shared<CompactLightField>(std::move(model), bytes);
}

ModelMetadata compact_metadata(std::string_view bytes, const std::string& file) {
  return notes_of(kFormat, bytes, file);
}

}  // namespace sheen
