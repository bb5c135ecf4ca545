// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/light_field_encoding.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "reconstructor/coding/difference_coding.h"
#include "reconstructor/light_field_file/encode/patch_encoding.h"
#include "reconstructor/light_field_file/encode/patch_steps.h"
#include "reconstructor/light_field_file/encode/resolution_encoding.h"
#include "reconstructor/light_field_file/encode/state_encoding.h"
#include "reconstructor/light_field_file/encode/vertex_encoding.h"
#include "reconstructor/light_field_file/file_layout.h"
#include "reconstructor/light_field_file/json_parts.h"

namespace sheen {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson description_of(const CompactModel& model, float step, const std::vector<double>& layer_squares) {
  OrderedJson kernels = OrderedJson::array();
  for (const ViewKernel& kernel : model.kernels) kernels.push_back(kernel_to_json(kernel));
  OrderedJson json{{"step", step},
                   {"patch_triangles", model.patch_triangles},
                   {"layers", layer_squares.size()},
                   {"layer_squares", layer_squares},
                   {"brightest", model.brightest},
                   {"kernels", kernels},
                   {"reflection", reflection_to_json(model.reflection.get())},
                   {"exposure", exposure_to_json(model.exposure)},
                   {"cameras", cameras_to_json(model.cameras)}};
  if (const Eigen::Vector3d& origin = model.mesh->origin; !origin.isZero(0))
    json["origin"] = {origin.x(), origin.y(), origin.z()};
  return json;
}

/// Little-endian 32-bit numbers, x y z each.
std::string encode_eyes(const std::vector<GridMesh::Point>& eyes) {
  return {reinterpret_cast<const char*>(eyes.data()), eyes.size() * sizeof(GridMesh::Point)};
}

/// Of a patch's means, the frequencies that the first layer leaves out: sum of squares, in grey levels.
double square_of_details(const QuantisedMap& mean, std::size_t bands, float step) {
  double sum = 0;
  for (std::size_t b = 0; b < bands; ++b) {
    const QuantisedMap::Band band = mean.band(b);
    for (std::size_t f = kSmoothFrequencies; f < band.size(); ++f) {
      const double value = double{step} * rounded_value(band[f]);
      sum += value * value;
    }
  }
  return sum;
}

/// What each layer adds to pictures, mean square per value, in grey levels: what a file that was cut short lacks.
std::vector<double> layer_squares(const CompactModel& model, const FileLayout& layout,
                                  const std::vector<QuantisedPatch>& patches, int layers) {
  std::vector<double> squares(static_cast<std::size_t>(layers), 0.0);
  double values = 0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (!patches[p].known) continue;
    const double here = 3.0 * model.shapes.patches[p].samples;
    values += here;
    squares[1] += square_of_details(patches[p].mean, 3 * layout.patches.tile_sizes[p].size(), layout.steps[p]);
    for (std::size_t k = 0; k < patches[p].terms.size(); ++k) {
      const double displayed = model.patches[p].displayed[static_cast<Eigen::Index>(k)];
      squares[kMeanLayers + k] += here * displayed * displayed;
    }
  }
  for (double& square : squares) square /= std::max(values, 1.0);
  return squares;
}

}  // namespace

std::string encode_light_field(CompactModel& model, const CanonicalMesh& mesh, float step, const Rounding& rounding,
                               const ForEach& for_each) {
  const std::string vertices = encode_vertices(model);  // first: reliabilities are those of the file from here on
  const std::vector<std::int8_t> patch_steps = choose_patch_steps(model, for_each);
  const FileLayout layout = file_layout(model, step, patch_steps, for_each);
  std::vector<QuantisedPatch> patches(model.patches.size());
  for_each(patches.size(), [&](std::size_t i) {
    patches[i] = quantise(model.patches[i], layout.resolutions[i], layout.plans[i], layout.steps[i], rounding);
  });
  std::vector<std::uint8_t> resolutions;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); ++t)
    resolutions.push_back(static_cast<std::uint8_t>(model.maps->resolution(t)));
  const int layers = layer_count(patches);

  std::string out = start_of_file(kLightFieldFile, {});
  append_chunk(out, "DESC", packed(description_of(model, step, layer_squares(model, layout, patches, layers)).dump()));
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

}  // namespace sheen
